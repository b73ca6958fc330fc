/* Actions: what the bindings that the program suggests make of the script's hands and buttons. */

#include "runtime.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_ACTIONS 64
#define MOST_BINDINGS 512

static const char *const HAND_NAMES[HANDS] = {"left", "right"};
#define ANY_HAND HANDS

typedef struct {
    bool active, changed;
    float x, y;
    XrTime since;
} Value;

struct Action {
    char name[64];
    XrActionType type;
    Value values[HANDS + 1]; /* of each hand, and of any */
};

typedef struct {
    XrPath profile, path;
    const Action *action;
} Binding;

static Action actions[MOST_ACTIONS];
static Binding bindings[MOST_BINDINGS];
static int action_count, binding_count, action_set;
static bool attached;
static char told_profiles[HANDS][64];

void forget_actions(void) {
    action_count = binding_count = 0;
    attached = false;
    memset(told_profiles, 0, sizeof told_profiles);
}

XrResult xrCreateActionSet(XrInstance instance, const XrActionSetCreateInfo *info,
                           XrActionSet *set) {
    (void)instance, (void)info;
    ENTER("xrCreateActionSet");
    forget_actions();
    *set = (XrActionSet)&action_set;
    return XR_SUCCESS;
}

XrResult xrDestroyActionSet(XrActionSet set) {
    (void)set;
    forget_actions();
    return XR_SUCCESS;
}

XrResult xrCreateAction(XrActionSet set, const XrActionCreateInfo *info, XrAction *action) {
    (void)set;
    ENTER("xrCreateAction");
    if (attached) return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
    if (action_count == MOST_ACTIONS) return XR_ERROR_LIMIT_REACHED;
    Action *made = &actions[action_count++];
    *made = (Action){.type = info->actionType};
    snprintf(made->name, sizeof made->name, "%s", info->actionName);
    *action = (XrAction)made;
    return XR_SUCCESS;
}

XrResult xrDestroyAction(XrAction action) {
    (void)action;
    return XR_SUCCESS;
}

XrResult xrSuggestInteractionProfileBindings(XrInstance instance,
                                             const XrInteractionProfileSuggestedBinding *suggested) {
    (void)instance;
    ENTER("xrSuggestInteractionProfileBindings");
    const char *profile = text_of(suggested->interactionProfile);
    if (profile == NULL) return XR_ERROR_PATH_INVALID;
    if (attached) return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
    for (uint32_t i = 0; i < suggested->countSuggestedBindings; i++) {
        const XrActionSuggestedBinding *each = &suggested->suggestedBindings[i];
        if (binding_count == MOST_BINDINGS) return XR_ERROR_LIMIT_REACHED;
        if (text_of(each->binding) == NULL) return XR_ERROR_PATH_INVALID;
        bindings[binding_count++] = (Binding){
            suggested->interactionProfile, each->binding, (const Action *)each->action,
        };
    }
    return XR_SUCCESS;
}

XrResult xrAttachSessionActionSets(XrSession session, const XrSessionActionSetsAttachInfo *info) {
    (void)session, (void)info;
    ENTER("xrAttachSessionActionSets");
    if (attached) return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
    attached = true;
    return XR_SUCCESS;
}

static int hand_of(XrPath path) {
    const char *text = text_of(path);
    for (int hand = 0; text != NULL && hand < HANDS; hand++) {
        char start[32];
        snprintf(start, sizeof start, "/user/hand/%s", HAND_NAMES[hand]);
        if (strncmp(text, start, strlen(start)) == 0) return hand;
    }
    return ANY_HAND;
}

static bool hand_is_there(int hand) {
    const double *active = scripted(ACTIVE, HAND_NAMES[hand], present_frame());
    return active == NULL || *active != 0;
}

/* Whether the program has suggested bindings of the profile that the script gives to a hand. */
static bool profile_fits(int hand) {
    char path[96];
    snprintf(path, sizeof path, "/interaction_profiles/%s", settings.profiles[hand]);
    XrPath profile = path_of(path);
    for (int i = 0; i < binding_count; i++)
        if (bindings[i].profile == profile) return true;
    return false;
}

static bool applies(const Binding *binding, int hand) {
    char path[96];
    int bound = hand_of(binding->path);
    if (bound == ANY_HAND || (hand != ANY_HAND && hand != bound)) return false;
    snprintf(path, sizeof path, "/interaction_profiles/%s", settings.profiles[bound]);
    return binding->profile == path_of(path) && hand_is_there(bound);
}

/* An input as pressed by its own path, or by that of the part of the controller. */
static const double *pressed(const char *path) {
    char part[128];
    const double *values = scripted(PRESS, path, present_frame());
    if (values != NULL) return values;
    snprintf(part, sizeof part, "%s", path);
    char *last = strrchr(part, '/');
    if (last == NULL) return NULL;
    *last = '\0';
    return scripted(PRESS, part, present_frame());
}

static Value value_of(const Action *action, int hand) {
    Value value = {0};
    for (int i = 0; i < binding_count; i++) {
        if (bindings[i].action != action || !applies(&bindings[i], hand)) continue;
        const double *values = pressed(text_of(bindings[i].path));
        value.active = true;
        if (values == NULL) continue;
        if ((float)values[0] > value.x) value.x = (float)values[0];
        if (action->type == XR_ACTION_TYPE_VECTOR2F_INPUT) {
            value.x = (float)values[0];
            value.y = (float)values[1];
        }
    }
    if (action->type == XR_ACTION_TYPE_BOOLEAN_INPUT) value.x = value.x > 0.5f;
    return value;
}

XrResult xrSyncActions(XrSession session, const XrActionsSyncInfo *info) {
    (void)session, (void)info;
    ENTER("xrSyncActions");
    if (!attached) return XR_ERROR_ACTIONSET_NOT_ATTACHED;
    for (int i = 0; i < action_count; i++)
        for (int hand = 0; hand <= HANDS; hand++) {
            Value *value = &actions[i].values[hand], before = *value;
            *value = is_focused() ? value_of(&actions[i], hand) : (Value){0};
            value->changed = value->active && before.active &&
                             (value->x != before.x || value->y != before.y);
            value->since = value->changed ? frame_time() : before.since;
        }
    return is_focused() ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

static const Value *state_of(const XrActionStateGetInfo *info) {
    return &((const Action *)info->action)->values[hand_of(info->subactionPath)];
}

XrResult xrGetActionStateBoolean(XrSession session, const XrActionStateGetInfo *info,
                                 XrActionStateBoolean *state) {
    (void)session;
    ENTER("xrGetActionStateBoolean");
    const Value *value = state_of(info);
    state->currentState = value->x != 0;
    state->changedSinceLastSync = value->changed;
    state->lastChangeTime = value->since;
    state->isActive = value->active;
    return XR_SUCCESS;
}

XrResult xrGetActionStateFloat(XrSession session, const XrActionStateGetInfo *info,
                               XrActionStateFloat *state) {
    (void)session;
    ENTER("xrGetActionStateFloat");
    const Value *value = state_of(info);
    state->currentState = value->x;
    state->changedSinceLastSync = value->changed;
    state->lastChangeTime = value->since;
    state->isActive = value->active;
    return XR_SUCCESS;
}

XrResult xrGetActionStateVector2f(XrSession session, const XrActionStateGetInfo *info,
                                  XrActionStateVector2f *state) {
    (void)session;
    ENTER("xrGetActionStateVector2f");
    const Value *value = state_of(info);
    state->currentState = (XrVector2f){value->x, value->y};
    state->changedSinceLastSync = value->changed;
    state->lastChangeTime = value->since;
    state->isActive = value->active;
    return XR_SUCCESS;
}

XrResult xrGetActionStatePose(XrSession session, const XrActionStateGetInfo *info,
                              XrActionStatePose *state) {
    (void)session;
    ENTER("xrGetActionStatePose");
    bool gaze = is_gaze((const Action *)info->action);
    state->isActive = gaze ? is_focused() : state_of(info)->active;
    return XR_SUCCESS;
}

/* Spaces of actions. */

bool is_gaze(const Action *action) {
    for (int i = 0; i < binding_count; i++)
        if (bindings[i].action == action)
            return strncmp(text_of(bindings[i].path), "/user/eyes_ext", 14) == 0;
    return false;
}

static Pose hand_pose(int hand) {
    const Pose held = {{hand == 0 ? -0.2 : 0.2, 1.2, -0.3}, {0, 0, 0, 1}};
    return scripted_pose(HAND, HAND_NAMES[hand], present_frame(), held);
}

Pose aim_of(const Action *action, XrPath path, bool *known) {
    if (is_gaze(action)) {
        *known = is_focused() && scripted(GAZE, NULL, present_frame()) != NULL;
        return scripted_pose(GAZE, NULL, present_frame(), IDENTITY);
    }
    int hand = hand_of(path);
    *known = is_focused() && action->values[hand].active;
    return hand == ANY_HAND ? IDENTITY : hand_pose(hand);
}

/* Profiles, sources and vibration. */

static const char *profile_of(int hand) {
    return attached && hand_is_there(hand) && profile_fits(hand) ? settings.profiles[hand] : "";
}

void update_profiles(XrSession session) {
    bool changed = false;
    for (int hand = 0; hand < HANDS; hand++) {
        changed |= strcmp(told_profiles[hand], profile_of(hand)) != 0;
        snprintf(told_profiles[hand], sizeof told_profiles[hand], "%s", profile_of(hand));
    }
    XrEventDataInteractionProfileChanged event = {
        XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, NULL, session,
    };
    if (changed) push_event(&event, sizeof event);
}

XrResult xrGetCurrentInteractionProfile(XrSession session, XrPath path,
                                        XrInteractionProfileState *state) {
    (void)session;
    ENTER("xrGetCurrentInteractionProfile");
    char text[96];
    int hand = hand_of(path);
    state->interactionProfile = XR_NULL_PATH;
    if (hand == ANY_HAND || profile_of(hand)[0] == '\0') return XR_SUCCESS;
    snprintf(text, sizeof text, "/interaction_profiles/%s", profile_of(hand));
    state->interactionProfile = path_of(text);
    return XR_SUCCESS;
}

XrResult xrEnumerateBoundSourcesForAction(XrSession session,
                                          const XrBoundSourcesForActionEnumerateInfo *info,
                                          uint32_t capacity, uint32_t *count, XrPath *sources) {
    (void)session;
    ENTER("xrEnumerateBoundSourcesForAction");
    XrPath found[MOST_BINDINGS];
    uint32_t number = 0;
    for (int i = 0; i < binding_count; i++)
        if (bindings[i].action == (const Action *)info->action && applies(&bindings[i], ANY_HAND))
            found[number++] = bindings[i].path;
    FILL(capacity, count, sources, number, found[i]);
}

XrResult xrGetInputSourceLocalizedName(XrSession session,
                                       const XrInputSourceLocalizedNameGetInfo *info,
                                       uint32_t capacity, uint32_t *count, char *buffer) {
    (void)session;
    ENTER("xrGetInputSourceLocalizedName");
    const char *text = text_of(info->sourcePath);
    if (text == NULL) return XR_ERROR_PATH_INVALID;
    FILL(capacity, count, buffer, strlen(text) + 1, text[i]);
}

XrResult xrApplyHapticFeedback(XrSession session, const XrHapticActionInfo *info,
                               const XrHapticBaseHeader *haptic) {
    (void)session;
    ENTER("xrApplyHapticFeedback");
    if (!is_focused()) return XR_SESSION_NOT_FOCUSED;
    const XrHapticVibration *vibration = (const void *)haptic;
    if (vibration->type != XR_TYPE_HAPTIC_VIBRATION) return XR_ERROR_VALIDATION_FAILURE;
    note("haptic %s %lld ns", text_of(info->subactionPath), (long long)vibration->duration);
    return XR_SUCCESS;
}

XrResult xrStopHapticFeedback(XrSession session, const XrHapticActionInfo *info) {
    (void)session;
    ENTER("xrStopHapticFeedback");
    note("haptic %s off", text_of(info->subactionPath));
    return XR_SUCCESS;
}

/* Joints of hands: a flat hand whose palm is where the hand is, fingers along its -Z. */

XrResult xrCreateHandTrackerEXT(XrSession session, const XrHandTrackerCreateInfoEXT *info,
                                XrHandTrackerEXT *tracker) {
    (void)session;
    ENTER("xrCreateHandTrackerEXT");
    static int hands[HANDS] = {0, 1};
    *tracker = (XrHandTrackerEXT)&hands[info->hand == XR_HAND_RIGHT_EXT];
    return XR_SUCCESS;
}

XrResult xrDestroyHandTrackerEXT(XrHandTrackerEXT tracker) {
    (void)tracker;
    return XR_SUCCESS;
}

XrResult xrLocateHandJointsEXT(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT *info,
                               XrHandJointLocationsEXT *locations) {
    ENTER("xrLocateHandJointsEXT");
    (void)info;
    int hand = *(const int *)tracker;
    Pose palm = hand_pose(hand);
    locations->isActive = is_focused() && hand_is_there(hand);
    if (locations->jointCount != XR_HAND_JOINT_COUNT_EXT) return XR_ERROR_VALIDATION_FAILURE;
    for (uint32_t joint = 0; joint < locations->jointCount; joint++) {
        uint32_t finger = joint < 2 ? 2 : (joint - 2) / 5, along = joint < 2 ? 0 : (joint - 2) % 5;
        Pose offset = {{0.02 * ((double)finger - 2), 0, -0.03 * along}, {0, 0, 0, 1}};
        Pose pose = pose_times(&palm, &offset);
        locations->jointLocations[joint] = (XrHandJointLocationEXT){
            locations->isActive ? 15 : 0, pose_to_xr(&pose), 0.008f,
        };
    }
    return XR_SUCCESS;
}

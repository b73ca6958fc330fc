/* The session: states, events, frames, views, reference spaces, and what the display has. */

#include "runtime.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_EVENTS 64
#define EYE_HEIGHT_M 1.6

static struct {
    bool exists, running, leaving, waited, begun, told_loss, told_mask, told_present, present;
    XrSessionState state;
    int frame;
    XrTime time;
    int64_t idle_since_ns;
    double rate_hz, period_ns;
    Pose origin;
} session = {.frame = -1};

static XrEventDataBuffer events[MOST_EVENTS];
static int first_event, event_count;

int present_frame(void) { return session.exists ? session.frame : -1; }
bool is_focused(void) { return session.running && session.state == XR_SESSION_STATE_FOCUSED; }
XrTime frame_time(void) { return session.time; }

void note(const char *format, ...) {
    if (settings.log[0] == '\0') return;
    FILE *file = fopen(settings.log, "a");
    if (file == NULL) return;
    va_list values;
    va_start(values, format);
    vfprintf(file, format, values);
    va_end(values);
    fputc('\n', file);
    fclose(file);
}

void push_event(const void *event, size_t size) {
    if (event_count == MOST_EVENTS) return;
    memcpy(&events[(first_event + event_count++) % MOST_EVENTS], event, size);
}

static void enter(XrSessionState state) {
    session.state = state;
    XrEventDataSessionStateChanged event = {
        XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, NULL, (XrSession)&session, state, display_now(),
    };
    push_event(&event, sizeof event);
}

static XrSessionState wanted_state(void) {
    static const char *const names[] = {
        [XR_SESSION_STATE_SYNCHRONIZED] = "synchronized", [XR_SESSION_STATE_VISIBLE] = "visible",
        [XR_SESSION_STATE_FOCUSED] = "focused",           [XR_SESSION_STATE_STOPPING] = "stopping",
        [XR_SESSION_STATE_LOSS_PENDING] = "loss_pending", [XR_SESSION_STATE_EXITING] = "exiting",
    };
    const char *name = scripted_state(session.frame < 0 ? 0 : session.frame);
    if (session.leaving) return XR_SESSION_STATE_EXITING;
    for (int i = XR_SESSION_STATE_SYNCHRONIZED; i <= XR_SESSION_STATE_EXITING; i++)
        if (strcmp(names[i], name) == 0) return (XrSessionState)i;
    return XR_SESSION_STATE_FOCUSED;
}

/* Goes one step towards the state that is wanted; returns whether there was one to go. */
static bool step(void) {
    XrSessionState state = session.state, wanted = wanted_state();
    bool ends = wanted > XR_SESSION_STATE_FOCUSED;
    if (state == XR_SESSION_STATE_LOSS_PENDING || state == wanted) return false;
    if (wanted == XR_SESSION_STATE_LOSS_PENDING) {
        enter(wanted);
    } else if (state == XR_SESSION_STATE_IDLE) {
        if (wanted == XR_SESSION_STATE_STOPPING) return false;
        enter(ends ? XR_SESSION_STATE_EXITING : XR_SESSION_STATE_READY);
    } else if (session.running && state == XR_SESSION_STATE_READY) {
        enter(XR_SESSION_STATE_SYNCHRONIZED);
    } else if (session.running && state != XR_SESSION_STATE_STOPPING) {
        XrSessionState down = ends ? XR_SESSION_STATE_SYNCHRONIZED : wanted;
        if (state < down) enter(state + 1);
        else if (state > down) enter(state - 1);
        else enter(XR_SESSION_STATE_STOPPING);
    } else {
        return false;
    }
    return true;
}

static void tell_presence(bool at_once) {
    if (!session.running || !is_enabled(XR_EXT_USER_PRESENCE_EXTENSION_NAME)) return;
    const double *value = scripted(PRESENT, NULL, session.frame);
    bool present = value == NULL || *value != 0;
    if (!at_once && present == session.present) return;
    session.present = present;
    XrEventDataUserPresenceChangedEXT event = {
        XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT, NULL, (XrSession)&session, present,
    };
    push_event(&event, sizeof event);
}

static void change_rate(double rate_hz) {
    XrEventDataDisplayRefreshRateChangedFB event = {
        XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB, NULL, (float)session.rate_hz,
        (float)rate_hz,
    };
    if (rate_hz == session.rate_hz) return;
    session.rate_hz = rate_hz;
    session.period_ns = 1e9 / rate_hz;
    if (is_enabled(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME)) push_event(&event, sizeof event);
}

static void change_mask(uint32_t eye) {
    XrEventDataVisibilityMaskChangedKHR event = {
        XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR, NULL, (XrSession)&session,
        XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, eye,
    };
    if (session.told_mask) return;
    session.told_mask = true;
    if (is_enabled(XR_KHR_VISIBILITY_MASK_EXTENSION_NAME)) push_event(&event, sizeof event);
}

static void move_origin(void) {
    Pose origin = scripted_pose(ORIGIN, NULL, session.frame, IDENTITY);
    if (memcmp(&origin, &session.origin, sizeof origin) == 0) return;
    Pose old_from_world = pose_inverse(&session.origin);
    Pose old_from_new = pose_times(&old_from_world, &origin);
    XrEventDataReferenceSpaceChangePending event = {
        XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING, NULL, (XrSession)&session,
        XR_REFERENCE_SPACE_TYPE_STAGE, session.time, XR_TRUE, pose_to_xr(&old_from_new),
    };
    session.origin = origin;
    push_event(&event, sizeof event);
}

/* What the script changes with the present frame becomes events. */
static void follow_script(void) {
    const double *rate_hz = scripted(RATE, NULL, session.frame);
    const double *mask_of = scripted(MASK, NULL, session.frame);
    while (step()) continue;
    tell_presence(false);
    if (rate_hz != NULL) change_rate(*rate_hz);
    if (mask_of != NULL) change_mask((uint32_t)*mask_of);
    move_origin();
    update_profiles((XrSession)&session);
    if (scripted(INSTANCE_LOSS, NULL, session.frame) != NULL && !session.told_loss) {
        XrEventDataInstanceLossPending event = {
            XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, NULL, display_now(),
        };
        session.told_loss = true;
        push_event(&event, sizeof event);
    }
}

/* While no frames are wanted, they pass with the time. */
static void pass_idle_frames(void) {
    int64_t now = machine_ns();
    if (session.running || session.frame < 0) {
        session.idle_since_ns = now;
        return;
    }
    int passed = (int)((double)(now - session.idle_since_ns) / session.period_ns);
    session.frame += passed;
    session.idle_since_ns += (int64_t)(passed * session.period_ns);
}

XrResult xrPollEvent(XrInstance instance, XrEventDataBuffer *event) {
    (void)instance;
    ENTER("xrPollEvent");
    if (session.exists) {
        pass_idle_frames();
        follow_script();
    }
    if (event_count == 0) return XR_EVENT_UNAVAILABLE;
    memcpy(event, &events[first_event], sizeof *event);
    first_event = (first_event + 1) % MOST_EVENTS;
    event_count--;
    return XR_SUCCESS;
}

XrResult xrCreateSession(XrInstance instance, const XrSessionCreateInfo *info,
                         XrSession *created) {
    (void)instance;
    ENTER("xrCreateSession");
    if (session.exists) return XR_ERROR_LIMIT_REACHED;
    XrResult bound = bind_graphics(info->next);
    if (bound != XR_SUCCESS) return bound;
    memset(&session, 0, sizeof session);
    session.exists = true;
    session.frame = -1;
    session.period_ns = settings.period_ns;
    session.rate_hz = settings.rates > 0 ? settings.rates_hz[0] : 0;
    session.origin = IDENTITY;
    first_event = event_count = 0;
    enter(XR_SESSION_STATE_IDLE);
    *created = (XrSession)&session;
    return XR_SUCCESS;
}

XrResult xrDestroySession(XrSession handle) {
    (void)handle;
    session.exists = session.running = false;
    event_count = 0;
    return destroy_swapchains();
}

XrResult xrBeginSession(XrSession handle, const XrSessionBeginInfo *info) {
    (void)handle;
    ENTER("xrBeginSession");
    if (session.running) return XR_ERROR_SESSION_RUNNING;
    if (session.state != XR_SESSION_STATE_READY) return XR_ERROR_SESSION_NOT_READY;
    if (info->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
        return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
    session.running = true;
    session.waited = session.begun = false;
    tell_presence(true);
    return XR_SUCCESS;
}

XrResult xrEndSession(XrSession handle) {
    (void)handle;
    ENTER("xrEndSession");
    if (!session.running) return XR_ERROR_SESSION_NOT_RUNNING;
    if (session.state != XR_SESSION_STATE_STOPPING) return XR_ERROR_SESSION_NOT_STOPPING;
    session.running = false;
    session.idle_since_ns = machine_ns();
    enter(XR_SESSION_STATE_IDLE);
    return XR_SUCCESS;
}

XrResult xrRequestExitSession(XrSession handle) {
    (void)handle;
    ENTER("xrRequestExitSession");
    if (!session.running) return XR_ERROR_SESSION_NOT_RUNNING;
    session.leaving = true;
    return XR_SUCCESS;
}

/* Frames. */

static bool wants_picture(void) {
    bool visible = session.state == XR_SESSION_STATE_VISIBLE ||
                   session.state == XR_SESSION_STATE_FOCUSED;
    return visible && !scripted_share(NOT_DRAWN, session.frame);
}

/* The next display time that can still be met; a frame is due a period before it is shown. */
static void wait_for_display(void) {
    double period = session.period_ns;
    const double *periods = scripted(LATE, NULL, session.frame);
    XrTime next = session.time + (XrTime)(period * (periods == NULL ? 1 : *periods));
    if (settings.speed > 0) {
        XrTime soonest = display_now() + (XrTime)(0.2 * period);
        if (session.time == 0) next = soonest + (XrTime)period;
        if (next < soonest)
            next += (XrTime)(ceil((double)(soonest - next) / period) * period);
        sleep_ns((int64_t)((double)(next - display_now() - (XrTime)period) / settings.speed));
    } else if (session.time == 0) {
        next = display_now();
    }
    session.time = next;
}

XrResult xrWaitFrame(XrSession handle, const XrFrameWaitInfo *info, XrFrameState *state) {
    (void)handle, (void)info;
    if (!session.running) return XR_ERROR_SESSION_NOT_RUNNING;
    session.frame++;
    ENTER("xrWaitFrame");
    follow_script();
    wait_for_display();
    const double *factor = scripted(PERIOD, NULL, session.frame);
    session.waited = true;
    state->predictedDisplayTime = session.time;
    state->predictedDisplayPeriod =
        (XrDuration)(session.period_ns * (factor == NULL ? 1 : *factor));
    state->shouldRender = wants_picture();
    return XR_SUCCESS;
}

XrResult xrBeginFrame(XrSession handle, const XrFrameBeginInfo *info) {
    (void)handle, (void)info;
    ENTER("xrBeginFrame");
    if (!session.running) return XR_ERROR_SESSION_NOT_RUNNING;
    if (!session.waited) return XR_ERROR_CALL_ORDER_INVALID;
    bool before = session.begun;
    session.waited = false;
    session.begun = true;
    return before ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

static XrResult check_projection(const XrCompositionLayerProjection *layer, int *depths) {
    if (layer->viewCount != 2) return XR_ERROR_VALIDATION_FAILURE;
    for (int eye = 0; eye < 2; eye++) {
        const XrCompositionLayerProjectionView *view = &layer->views[eye];
        const XrBaseInStructure *next = view->next;
        if (!pose_is_valid(&view->pose)) return XR_ERROR_POSE_INVALID;
        if (!was_drawn(&view->subImage)) return XR_ERROR_LAYER_INVALID;
        if (next == NULL || next->type != XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR) continue;
        const XrCompositionLayerDepthInfoKHR *depth = (const void *)next;
        if (!was_drawn(&depth->subImage)) return XR_ERROR_LAYER_INVALID;
        if (depth->minDepth != 0 || depth->maxDepth != 1) return XR_ERROR_VALIDATION_FAILURE;
        (*depths)++;
    }
    return XR_SUCCESS;
}

static XrResult check_layer(const XrCompositionLayerBaseHeader *layer, int *depths) {
    if (layer == NULL || layer->space == XR_NULL_HANDLE) return XR_ERROR_LAYER_INVALID;
    if (layer->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION)
        return check_projection((const void *)layer, depths);
    if (layer->type != XR_TYPE_COMPOSITION_LAYER_QUAD) return XR_ERROR_LAYER_INVALID;
    const XrCompositionLayerQuad *quad = (const void *)layer;
    if (!pose_is_valid(&quad->pose)) return XR_ERROR_POSE_INVALID;
    return was_drawn(&quad->subImage) ? XR_SUCCESS : XR_ERROR_LAYER_INVALID;
}

XrResult xrEndFrame(XrSession handle, const XrFrameEndInfo *info) {
    (void)handle;
    ENTER("xrEndFrame");
    int depths = 0, eyes = 0;
    if (!session.running) return XR_ERROR_SESSION_NOT_RUNNING;
    if (!session.begun) return XR_ERROR_CALL_ORDER_INVALID;
    if (info->displayTime != session.time) return XR_ERROR_TIME_INVALID;
    if (info->environmentBlendMode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE)
        return XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED;
    if (info->layerCount > 16) return XR_ERROR_LAYER_LIMIT_EXCEEDED;
    if (!is_bound_current()) return XR_ERROR_RUNTIME_FAILURE;
    for (uint32_t i = 0; i < info->layerCount; i++) {
        XrResult checked = check_layer(info->layers[i], &depths);
        if (checked != XR_SUCCESS) return checked;
        eyes += info->layers[i]->type == XR_TYPE_COMPOSITION_LAYER_PROJECTION;
    }
    session.begun = false;
    note("frame %d time %lld state %d layers %u eyes %d depths %d", session.frame,
         (long long)session.time, session.state, info->layerCount, eyes, depths);
    return XR_SUCCESS;
}

/* Where head, eyes and hands are. */

static Pose head(void) {
    static const Pose standing = {{0, EYE_HEIGHT_M, 0}, {0, 0, 0, 1}};
    return scripted_pose(HEAD, NULL, session.frame, standing);
}

static bool head_known(void) { return !scripted_share(INVALID, session.frame); }
static bool head_tracked(void) { return head_known() && !scripted_share(UNTRACKED, session.frame); }

typedef struct {
    XrReferenceSpaceType type;
    const Action *action;
    XrPath hand;
    Pose offset;
} Space;

static const XrReferenceSpaceType REFERENCES[] = {
    XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL, XR_REFERENCE_SPACE_TYPE_STAGE,
    XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT,
};

XrResult xrEnumerateReferenceSpaces(XrSession handle, uint32_t capacity, uint32_t *count,
                                    XrReferenceSpaceType *types) {
    (void)handle;
    ENTER("xrEnumerateReferenceSpaces");
    int number = is_enabled(XR_EXT_LOCAL_FLOOR_EXTENSION_NAME) ? 4 : 3;
    FILL(capacity, count, types, number, REFERENCES[i]);
}

static XrResult make_space(Space space, XrSpace *created) {
    Space *kept = malloc(sizeof *kept);
    if (kept == NULL) return XR_ERROR_OUT_OF_MEMORY;
    *kept = space;
    *created = (XrSpace)kept;
    return XR_SUCCESS;
}

XrResult xrCreateReferenceSpace(XrSession handle, const XrReferenceSpaceCreateInfo *info,
                                XrSpace *created) {
    (void)handle;
    ENTER("xrCreateReferenceSpace");
    if (!pose_is_valid(&info->poseInReferenceSpace)) return XR_ERROR_POSE_INVALID;
    Space space = {info->referenceSpaceType, NULL, 0, pose_of(&info->poseInReferenceSpace)};
    return make_space(space, created);
}

XrResult xrCreateActionSpace(XrSession handle, const XrActionSpaceCreateInfo *info,
                             XrSpace *created) {
    (void)handle;
    ENTER("xrCreateActionSpace");
    Space space = {0, (const Action *)info->action, info->subactionPath,
                   pose_of(&info->poseInActionSpace)};
    return make_space(space, created);
}

XrResult xrDestroySpace(XrSpace space) {
    free((void *)space);
    return XR_SUCCESS;
}

XrResult xrGetReferenceSpaceBoundsRect(XrSession handle, XrReferenceSpaceType type,
                                       XrExtent2Df *bounds) {
    (void)handle, (void)type;
    ENTER("xrGetReferenceSpaceBoundsRect");
    *bounds = (XrExtent2Df){3, 2};
    return XR_SUCCESS;
}

static Pose world_from(const Space *space, bool *known, bool *tracked) {
    Pose pose = session.origin;
    *known = *tracked = true;
    if (space->action != NULL) {
        pose = aim_of(space->action, space->hand, known);
        *tracked = *known;
    } else if (space->type == XR_REFERENCE_SPACE_TYPE_VIEW) {
        pose = head();
        *known = head_known();
        *tracked = head_tracked();
    } else if (space->type == XR_REFERENCE_SPACE_TYPE_LOCAL) {
        static const Pose raised = {{0, EYE_HEIGHT_M, 0}, {0, 0, 0, 1}};
        pose = pose_times(&pose, &raised);
    }
    return pose_times(&pose, &space->offset);
}

XrResult xrLocateSpace(XrSpace of, XrSpace base, XrTime time, XrSpaceLocation *location) {
    ENTER("xrLocateSpace");
    if (time <= 0) return XR_ERROR_TIME_INVALID;
    const Space *space = (const Space *)of;
    bool known, tracked, base_known, base_tracked;
    Pose world_from_space = world_from(space, &known, &tracked);
    Pose world_from_base = world_from((const Space *)base, &base_known, &base_tracked);
    Pose base_from_world = pose_inverse(&world_from_base);
    Pose pose = pose_times(&base_from_world, &world_from_space);
    location->locationFlags = 0;
    if (known && base_known)
        location->locationFlags |=
            XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    if (tracked && base_tracked)
        location->locationFlags |=
            XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    location->pose = pose_to_xr(&pose);
    XrEyeGazeSampleTimeEXT *sample = location->next;
    if (sample != NULL && sample->type == XR_TYPE_EYE_GAZE_SAMPLE_TIME_EXT)
        sample->time = known ? session.time - 8000000 : 0;
    return XR_SUCCESS;
}

XrResult xrLocateViews(XrSession handle, const XrViewLocateInfo *info, XrViewState *state,
                       uint32_t capacity, uint32_t *count, XrView *views) {
    (void)handle;
    ENTER("xrLocateViews");
    if (info->displayTime <= 0) return XR_ERROR_TIME_INVALID;
    bool known, tracked;
    Pose world_from_base = world_from((const Space *)info->space, &known, &tracked);
    Pose base_from_world = pose_inverse(&world_from_base), world_from_head = head();
    Pose base_from_head = pose_times(&base_from_world, &world_from_head);
    state->viewStateFlags = 0;
    if (head_known())
        state->viewStateFlags |=
            XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    if (head_tracked())
        state->viewStateFlags |=
            XR_VIEW_STATE_ORIENTATION_TRACKED_BIT | XR_VIEW_STATE_POSITION_TRACKED_BIT;
    *count = 2;
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < 2) return XR_ERROR_SIZE_INSUFFICIENT;
    for (int eye = 0; eye < 2; eye++) {
        Pose head_from_eye = {{(eye - 0.5) * settings.ipd_m, 0, 0}, {0, 0, 0, 1}};
        Pose pose = pose_times(&base_from_head, &head_from_eye);
        views[eye].pose = pose_to_xr(&pose);
        views[eye].fov = (XrFovf){-0.75f + 0.05f * eye, 0.7f + 0.05f * eye, 0.7f, -0.7f};
    }
    return XR_SUCCESS;
}

/* The display. */

XrResult xrEnumerateDisplayRefreshRatesFB(XrSession handle, uint32_t capacity, uint32_t *count,
                                          float *rates) {
    (void)handle;
    ENTER("xrEnumerateDisplayRefreshRatesFB");
    FILL(capacity, count, rates, settings.rates, (float)settings.rates_hz[i]);
}

XrResult xrGetDisplayRefreshRateFB(XrSession handle, float *rate) {
    (void)handle;
    ENTER("xrGetDisplayRefreshRateFB");
    *rate = (float)session.rate_hz;
    return XR_SUCCESS;
}

XrResult xrRequestDisplayRefreshRateFB(XrSession handle, float wanted) {
    (void)handle;
    ENTER("xrRequestDisplayRefreshRateFB");
    for (uint32_t i = 0; i < settings.rates; i++)
        if ((float)settings.rates_hz[i] == wanted) {
            change_rate(settings.rates_hz[i]);
            return XR_SUCCESS;
        }
    return wanted == 0 ? XR_SUCCESS : XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB;
}

/* The lens hides the four corners of each eye's image. */
XrResult xrGetVisibilityMaskKHR(XrSession handle, XrViewConfigurationType type, uint32_t eye,
                                XrVisibilityMaskTypeKHR kind, XrVisibilityMaskKHR *mask) {
    (void)handle, (void)type, (void)eye;
    ENTER("xrGetVisibilityMaskKHR");
    static const float across[] = {-0.9f, 0.9f}, cut = 0.2f;
    mask->vertexCountOutput = mask->indexCountOutput =
        kind == XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR ? 12 : 0;
    if (mask->vertexCountOutput == 0 || mask->vertexCapacityInput == 0) return XR_SUCCESS;
    if (mask->vertexCapacityInput < 12 || mask->indexCapacityInput < 12)
        return XR_ERROR_SIZE_INSUFFICIENT;
    for (uint32_t i = 0; i < 12; i++) {
        float x = across[i / 3 % 2], y = across[i / 6];
        uint32_t along = x * y > 0 ? 1 : 2; /* so that all go around the same way */
        if (i % 3 == along) x *= 1 - cut;
        else if (i % 3 != 0) y *= 1 - cut;
        mask->vertices[i] = (XrVector2f){x, y};
        mask->indices[i] = i;
    }
    return XR_SUCCESS;
}

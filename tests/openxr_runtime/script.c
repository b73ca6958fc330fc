/* The script of the test runtime: what it is, and what it does in which frame.

The environment variable VRCOMFORT_TEST_SCRIPT names a text file. A line is a setting or a rule;
`#` begins a comment. A program in the same process adds lines while it runs (`runtime_say`).

Settings hold from the beginning:

    headset NAME               of the system; "Simulated headset" without
    runtime NAME
    size WIDTH HEIGHT          of one eye's image, in pixels
    period_ns NS               between two frames; 11111111 without
    rates HZ...                of XR_FB_display_refresh_rate; the first is the one at the start
    speed FACTOR               of the display's clock, by the machine's; 0: frames do not wait
    ipd_m METRES
    profile left|right PATH    of a hand, below /interaction_profiles/; valve/index_controller
    without EXTENSION          is not offered
    eyes                       it has an eye tracker
    seed NUMBER                of what happens by chance
    log FILE                   gets a line for each frame that was ended, each tick, and the like

Rules hold in some frames. These are numbered from 0 with each session: FRAME (from there on),
FROM-TO (both included), `start` (from before the first on), or `now` (from the one on that is
waited for next, in the place of the `now` before). While the runtime does not want frames, they
are counted by time. Of the rules of one kind and key, the last that
holds counts, so that a frame is the same whatever came before it:

    FRAMES head X Y Z QX QY QZ QW        stage-from-head, metres and a quaternion
    FRAMES hand left|right X Y Z QX QY QZ QW    where a controller is, and points: along its -Z
    FRAMES active left|right 0|1         whether there is one; 1 without
    FRAMES gaze X Y Z QX QY QZ QW        from which, and along which -Z, both eyes look
    FRAMES press PATH VALUE [VALUE]      an input: /user/hand/left/input/trigger/value; without
                                         the last part all of them (value, click, touch)
    FRAMES state NAME                    that the runtime goes to, step by step: focused (without
                                         a rule), visible, synchronized, stopping, exiting,
                                         loss_pending
    FRAMES instance_loss                 is announced
    FRAMES present 0|1                   what the headset's sensor sees; 1 without
    FRAMES not_drawn PERCENT             of frames, by chance, of which no picture is wanted
    FRAMES invalid PERCENT               of frames in which the head is not known
    FRAMES untracked PERCENT             of frames in which the head's pose is inferred
    FRAMES period FACTOR                 by which the predicted period is wrong; 0: not told
    FRAMES late PERIODS                  that a frame takes
    FRAMES rate HZ                       that the display changes to, and tells
    FRAMES mask 0|1                      of which eye the visibility mask changes, and is told
    FRAMES origin X Y Z QX QY QZ QW      of the stage, where the runtime moves it to, and tells
    FRAMES answer FUNCTION RESULT        a number of OpenXR's, and nothing is done; FUNCTION * is
                                         every function of a session
    FRAMES hang FUNCTION SECONDS         before it does what it does, once */

#include "runtime.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    int from, to;
    bool now;
    char key[96];
    double values[7];
} Rule;

typedef struct {
    Rule *rules;
    int count, room;
} Rules;

static const struct {
    const char *name;
    bool has_key;
    int least, most;
} KIND[KINDS] = {
    [HEAD] = {"head", false, 7, 7},         [HAND] = {"hand", true, 7, 7},
    [GAZE] = {"gaze", false, 7, 7},         [ORIGIN] = {"origin", false, 7, 7},
    [ACTIVE] = {"active", true, 1, 1},      [PRESS] = {"press", true, 1, 2},
    [STATE] = {"state", true, 0, 0},        [PRESENT] = {"present", false, 1, 1},
    [NOT_DRAWN] = {"not_drawn", false, 1, 1}, [INVALID] = {"invalid", false, 1, 1},
    [UNTRACKED] = {"untracked", false, 1, 1}, [PERIOD] = {"period", false, 1, 1},
    [MASK] = {"mask", false, 1, 1},
    [RATE] = {"rate", false, 1, 1},         [LATE] = {"late", false, 1, 1},
    [ANSWER] = {"answer", true, 1, 1},      [HANG] = {"hang", true, 1, 1},
    [INSTANCE_LOSS] = {"instance_loss", false, 0, 0},
};

Settings settings;
static Rules rules_of[KINDS];
static char lacking[32][128];
static int lacks;

static bool read_setting(const char *name, char *rest) {
    char hand[8];
    int lengths = 0;
    if (strcmp(name, "headset") == 0)
        return snprintf(settings.headset, sizeof settings.headset, "%s", rest) > 0;
    if (strcmp(name, "runtime") == 0)
        return snprintf(settings.runtime, sizeof settings.runtime, "%s", rest) > 0;
    if (strcmp(name, "log") == 0)
        return snprintf(settings.log, sizeof settings.log, "%s", rest) > 0;
    if (strcmp(name, "size") == 0)
        return sscanf(rest, "%u %u", &settings.width, &settings.height) == 2;
    if (strcmp(name, "period_ns") == 0) return sscanf(rest, "%lf", &settings.period_ns) == 1;
    if (strcmp(name, "speed") == 0) return sscanf(rest, "%lf", &settings.speed) == 1;
    if (strcmp(name, "ipd_m") == 0) return sscanf(rest, "%lf", &settings.ipd_m) == 1;
    if (strcmp(name, "seed") == 0) return sscanf(rest, "%u", &settings.seed) == 1;
    if (strcmp(name, "eyes") == 0) return settings.eyes = true;
    if (strcmp(name, "without") == 0)
        return lacks < 32 && sscanf(rest, "%127s", lacking[lacks++]) == 1;
    if (strcmp(name, "profile") == 0) {
        if (sscanf(rest, "%7s %n", hand, &lengths) != 1) return false;
        char *profile = settings.profiles[strcmp(hand, "right") == 0];
        return sscanf(rest + lengths, "%63s", profile) == 1;
    }
    if (strcmp(name, "rates") == 0) {
        for (settings.rates = 0; settings.rates < MOST_RATES; settings.rates++) {
            if (sscanf(rest, "%lf%n", &settings.rates_hz[settings.rates], &lengths) != 1) break;
            rest += lengths;
        }
        return settings.rates > 0;
    }
    return false;
}

static bool add_rule(Kind kind, Rule rule, char *rest) {
    int used = 0, count = 0;
    if (KIND[kind].has_key) {
        if (sscanf(rest, "%95s%n", rule.key, &used) != 1) return false;
        rest += used;
    }
    while (count < KIND[kind].most && sscanf(rest, "%lf%n", &rule.values[count], &used) == 1) {
        rest += used;
        count++;
    }
    if (count < KIND[kind].least || rest[strspn(rest, " \r\n\t")] != '\0') return false;
    Rules *rules = &rules_of[kind];
    for (int i = 0; rule.now && i < rules->count; i++)
        if (rules->rules[i].now && strcmp(rules->rules[i].key, rule.key) == 0) {
            rules->rules[i] = rule;
            return true;
        }
    if (rules->count == rules->room) {
        rules->room = rules->room ? 2 * rules->room : 64;
        rules->rules = realloc(rules->rules, (size_t)rules->room * sizeof(Rule));
        if (rules->rules == NULL) abort();
    }
    rules->rules[rules->count++] = rule;
    return true;
}

static bool read_rule(const char *when, char *rest) {
    Rule rule = {.from = -1, .to = INT32_MAX, .now = strcmp(when, "now") == 0};
    int used = 0;
    char name[32];
    if (rule.now) rule.from = present_frame() + 1;
    else if (strcmp(when, "start") != 0 && sscanf(when, "%d-%d", &rule.from, &rule.to) < 1)
        return false;
    if (sscanf(rest, "%31s%n", name, &used) != 1) return false;
    for (Kind kind = 0; kind < KINDS; kind++)
        if (strcmp(name, KIND[kind].name) == 0) return add_rule(kind, rule, rest + used);
    return false;
}

static bool read_line(char *line) {
    char first[32];
    int used = 0;
    line[strcspn(line, "#\r\n")] = '\0';
    if (sscanf(line, "%31s %n", first, &used) != 1) return true;
    if (strcmp(first, "start") == 0 || strcmp(first, "now") == 0 || strchr("0123456789", first[0]))
        return read_rule(first, line + used);
    return read_setting(first, line + used);
}

/* Adds a line; returns whether it is one. */
EXPORTED int runtime_say(const char *line) {
    char copy[1024];
    snprintf(copy, sizeof copy, "%s", line);
    return read_line(copy);
}

static const char *script_name(void) {
#ifdef _WIN32 /* the program's C library may be another, with variables of its own */
    static char name[1024];
    return GetEnvironmentVariableA("VRCOMFORT_TEST_SCRIPT", name, sizeof name) ? name : NULL;
#else
    return getenv("VRCOMFORT_TEST_SCRIPT");
#endif
}

bool read_script(void) {
    for (int kind = 0; kind < KINDS; kind++) rules_of[kind].count = 0;
    lacks = 0;
    settings = (Settings){
        .headset = "Simulated headset", .runtime = "vrcomfort test runtime",
        .profiles = {"valve/index_controller", "valve/index_controller"},
        .width = 64, .height = 80, .period_ns = 11111111, .ipd_m = 0.064, .speed = 1,
    };
    const char *name = script_name();
    if (name == NULL) return true;
    FILE *file = fopen(name, "r");
    char line[1024];
    int number = 0;
    bool good = file != NULL;
    if (file == NULL) fprintf(stderr, "test runtime: cannot read %s\n", name);
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        number++;
        if (read_line(line)) continue;
        fprintf(stderr, "test runtime: %s, line %d: not understood\n", name, number);
        good = false;
    }
    if (file != NULL) fclose(file);
    if (settings.rates > 0) settings.period_ns = 1e9 / settings.rates_hz[0];
    return good;
}

bool script_has(const char *extension) {
    for (int i = 0; i < lacks; i++)
        if (strcmp(lacking[i], extension) == 0) return false;
    if (strcmp(extension, "XR_FB_display_refresh_rate") == 0) return settings.rates > 0;
    if (strcmp(extension, "XR_EXT_eye_gaze_interaction") == 0) return settings.eyes;
    return true;
}

static Rule *find_rule(Kind kind, const char *key, int frame) {
    Rules *rules = &rules_of[kind];
    for (int i = rules->count - 1; i >= 0; i--) {
        Rule *rule = &rules->rules[i];
        if (rule->from <= frame && frame <= rule->to && (!key || strcmp(rule->key, key) == 0))
            return rule;
    }
    return NULL;
}

const double *scripted(Kind kind, const char *key, int frame) {
    Rule *rule = find_rule(kind, key, frame);
    return rule == NULL ? NULL : rule->values;
}

const char *scripted_state(int frame) {
    Rule *rule = find_rule(STATE, NULL, frame);
    return rule == NULL ? "focused" : rule->key;
}

Pose scripted_pose(Kind kind, const char *key, int frame, Pose otherwise) {
    const double *v = scripted(kind, key, frame);
    if (v == NULL) return otherwise;
    double length = sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
    Pose pose = {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
    for (int i = 0; i < 4; i++) pose.q[i] /= length;
    return pose;
}

/* By chance, but the same for the same seed, kind and frame. */
bool scripted_share(Kind kind, int frame) {
    const double *percent = scripted(kind, NULL, frame);
    if (percent == NULL) return false;
    uint32_t h = settings.seed * 0x9e3779b9u ^ (uint32_t)kind * 0x85ebca6bu ^ (uint32_t)frame;
    for (int i = 0; i < 2; i++) { /* the finaliser of MurmurHash3, twice */
        h = (h ^ h >> 16) * 0x85ebca6bu;
        h = (h ^ h >> 13) * 0xc2b2ae35u;
        h ^= h >> 16;
    }
    return h < *percent / 100 * 4294967296.0;
}

XrResult scripted_result(const char *function) {
    int frame = present_frame();
    Rule *hang = find_rule(HANG, function, frame);
    if (hang != NULL) {
        hang->to = hang->from - 1; /* once */
        sleep_ns((int64_t)(hang->values[0] * 1e9));
    }
    const double *result = scripted(ANSWER, function, frame);
    if (result == NULL && frame >= 0) result = scripted(ANSWER, "*", frame);
    return result == NULL ? XR_SUCCESS : (XrResult)*result;
}

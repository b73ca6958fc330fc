// Motion on the image: pixels per frame, now minus before, +x right, +y up.
//
// NumPy twins: tests/oracles/motion.py.

const float SPEED_LIMIT_PX = 16384.0;  // half floats hold it; far above every streak limit
const float AS_THE_EYE = 32768.0;      // x of what only the eye's motion moves; its depth says how far
const float BEHIND = 1e-3;  // what was behind the eye came from its rim: least ratio of w
const float LEAST_W = 1e-6;            // rims of triangles are interpolated past the eye

vec2 shorten(vec2 vector, float limit) {
    return vector * (limit / max(length(vector), limit));
}

// Velocity of a surface point in front of the eye (clip_now.w > 0) from its two clip positions.
vec2 velocity_px(vec4 clip_now, vec4 clip_before, vec2 size_px) {
    float now = max(clip_now.w, LEAST_W);
    float before = max(clip_before.w, BEHIND * now);
    vec2 v = (clip_now.xy / now - clip_before.xy / before) * 0.5 * size_px;
    return shorten(v, SPEED_LIMIT_PX);
}

// How far a point moves from the middle of the shutter's opening to its end.
vec2 half_velocity_px(vec2 velocity, float shutter_fraction, float max_radius_px) {
    return shorten(velocity * (0.5 * shutter_fraction), max_radius_px);
}

// The integral of a tent of half width 1, from far below up to x.
float tent_integral(float x) {
    float rest = 1.0 - min(abs(x), 1.0);
    float beyond = 0.5 * rest * rest;
    return x < 0.0 ? beyond : 1.0 - beyond;
}

// How long a streak from -reach to +reach px is over a pixel k px away, in px of its way, where the
// image between pixels is interpolated linearly. Over all pixels this sums to 2 reach.
float time_over(float k, float reach) {
    return tent_integral(k + reach) - tent_integral(k - reach);
}

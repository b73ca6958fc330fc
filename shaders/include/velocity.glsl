// Motion on the image: pixels per frame, now minus before, +x right, +y up.
//
// NumPy twins: vrcomfort/optics/motion.py.

const float SPEED_LIMIT_PX = 16384.0;  // half floats hold it; far above every streak limit
const float BEHIND = 1e-3;  // what was behind the eye came from its rim: least ratio of w

vec2 shorten(vec2 vector, float limit) {
    return vector * (limit / max(length(vector), limit));
}

// Velocity of a surface point in front of the eye (clip_now.w > 0) from its two clip positions.
vec2 velocity_px(vec4 clip_now, vec4 clip_before, vec2 size_px) {
    float w = max(clip_before.w, BEHIND * clip_now.w);
    return shorten((clip_now.xy / clip_now.w - clip_before.xy / w) * 0.5 * size_px, SPEED_LIMIT_PX);
}

// How far a point moves from the middle of the shutter's opening to its end.
vec2 half_streak_px(vec2 velocity, float shutter_fraction, float radius_limit_px) {
    return shorten(velocity * (0.5 * shutter_fraction), radius_limit_px);
}

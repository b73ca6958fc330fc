// Half velocities from velocities: how far a point moves from mid-shutter to the shutter's end, px.
//
// Include velocity.glsl first. A point spreads from -u to +u around where it is drawn: RADII.
// Twins of what is in velocity.glsl.

uniform eye_image velocity;       // px per frame, now minus before, +x right, +y up
uniform float shutter_fraction;   // of the frame period, times the scale of the frame
uniform float max_radius_px;    // no half velocity is longer

// What is not a number moves nothing.
vec2 velocity_at(ivec2 pixel) {
    vec2 v = texel_of(velocity, pixel).xy;
    return clamp(mix(v, vec2(0.0), isnan(v)), -SPEED_LIMIT_PX, SPEED_LIMIT_PX);
}

vec2 half_velocity_at(ivec2 pixel) {
    return half_velocity_px(velocity_at(pixel), shutter_fraction, max_radius_px);
}

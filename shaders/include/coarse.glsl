// Very wide discs on texels of LEVEL px: how wide a disc is there, and what a texel knows of the
// foreground.
//
// Radii are signed where they are called so, in pixels of image width; negative in front of the focus.
// Twins: tests/oracles/coarse_layers.py.

// Radius in texels: such texels and their enlargement blur by themselves, with this variance.
const float LEVEL_VARIANCE_PX2 = float(LEVEL * LEVEL - 1) / 3.0;

float disc_texels(float radius_px) {
    float own_px = sqrt(max(radius_px * radius_px - 4.0 * LEVEL_VARIANCE_PX2, 0.0));
    return max(own_px / float(LEVEL), 0.5);
}

// The signed radius of a foreground and how much of the texel it covers (0 to 1), in one number.
const float STEPS_PER_PX = 64.0;

float packed_foreground(float signed_px, float coverage) {
    return floor(signed_px * STEPS_PER_PX + 0.5) + 0.5 * coverage;
}

vec2 unpacked_foreground(float packed_) {
    float whole = floor(packed_);
    return vec2(whole / STEPS_PER_PX, 2.0 * (packed_ - whole));
}

#version 450 core
// Between which radii the discs of a tile lie.
//
// Input:  half_image of half_resolution.frag (signed CoC RADIUS, px of the whole image, negative in
//         front of the focus). With DILATE: tiles of this shader.
// Output: r = least RADIUS, g = greatest, signed; a texel is TILE x TILE texels. With DILATE: of the
//         3x3 tiles around whose discs are wider than FROM_PX.
// NumPy twin: tests/oracles/half_resolution.py. As the tiles of Filament's depth of field.
#include "eyes.glsl"
uniform eye_image source;

out vec2 radii_px;

void main() {
    ivec2 last = size_of(source) - 1;
    radii_px = vec2(HALF_MAX, -HALF_MAX);
#ifdef DILATE
    for (int i = 0; i < 9; ++i) {
        ivec2 tile = ivec2(gl_FragCoord.xy) + ivec2(i % 3, i / 3) - 1;
        vec2 other_px = texel_of(source, clamp(tile, ivec2(0), last)).rg;
        // Of tiles that have come this far, discs that are narrower cannot reach this one.
        other_px = i == 4 || FROM_PX == 0.0 ? other_px : vec2(other_px.r < -FROM_PX ? other_px.r : HALF_MAX,
                                                            other_px.g > FROM_PX ? other_px.g : -HALF_MAX);
        radii_px = vec2(min(radii_px.r, other_px.r), max(radii_px.g, other_px.g));
    }
#else
    for (int i = 0; i < TILE * TILE; ++i) {
        ivec2 texel = TILE * ivec2(gl_FragCoord.xy) + ivec2(i % TILE, i / TILE);
        float radius_px = texel_of(source, min(texel, last)).a;
        radii_px = vec2(min(radii_px.r, radius_px), max(radii_px.g, radius_px));
    }
#endif
}

#version 450 core
// A square for each tile of some KINDS; the other tiles collapse into nothing.
//
// Input:  gl_VertexID, six for each tile; reach (defocus_reach.frag); points for the image's size.
//         RIM: also tiles of other kinds beside one of KINDS, for bilinear reads across the rim.
// Output: the square in clip space; what reaches over the image is clipped.
#include "tap_kinds.glsl"

uniform sampler2D reach;
uniform sampler2D points;

const ivec2 CORNERS[6] = ivec2[](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1),
                                 ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));

bool is_kind(ivec2 tile, int kinds) {
    ivec2 last = textureSize(reach, 0) - 1;
    return (tap_kind(texelFetch(reach, clamp(tile, ivec2(0), last), 0)) & kinds) != 0;
}

bool is_drawn(ivec2 tile) {
    bool found = is_kind(tile, (KINDS));
#ifdef RIM
    if (!found && !is_kind(tile, WIDE | WIDEST))
        for (int i = 0; i < 9; ++i)
            found = found || is_kind(tile + ivec2(i % 3, i / 3) - 1, (KINDS));
#endif
    return found;
}

void main() {
    int columns = textureSize(reach, 0).x;
    ivec2 tile = ivec2(gl_VertexID / 6 % columns, gl_VertexID / 6 / columns);
    vec2 at_px = vec2(TILE * (tile + CORNERS[gl_VertexID % 6]));
    vec2 size_px = vec2(textureSize(points, 0));
    gl_Position = is_drawn(tile) ? vec4(2.0 * at_px / size_px - 1.0, 0.0, 1.0) : vec4(0.0, 0.0, 0.0, 1.0);
}

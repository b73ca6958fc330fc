#version 450 core
// A square point on each tile of some KINDS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; reach (tap_reach.frag).
//         RIM: also tiles of other kinds beside one of KINDS, for bilinear reads across the rim.
// Output: the point in clip space of the image rounded up to whole tiles. Points, not triangles:
//         those would have every block of pixels along a diagonal drawn twice.
#include "tap_kinds.glsl"

uniform sampler2D reach;

int kind(ivec2 tile) {
    return int(texelFetch(reach, clamp(tile, ivec2(0), textureSize(reach, 0) - 1), 0).b);
}

bool is_drawn(ivec2 tile) {
    int found = kind(tile);
#ifdef RIM
    if ((found & (WIDE | WIDEST)) == 0)
        for (int i = 0; i < 9; ++i)
            found |= kind(tile + ivec2(i % 3, i / 3) - 1);
#endif
    return (found & (KINDS)) != 0;
}

void main() {
    ivec2 tiles = textureSize(reach, 0);
    ivec2 tile = ivec2(gl_VertexID % tiles.x, gl_VertexID / tiles.x);
    vec2 middle = (vec2(tile) + 0.5) / vec2(tiles);
    gl_PointSize = float(POINT_PX);
    gl_Position = vec4(is_drawn(tile) ? 2.0 * middle - 1.0 : vec2(-2.0), 0.0, 1.0);
}

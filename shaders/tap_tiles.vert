#version 450 core
// A square point on each tile of some KINDS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; reach (tap_reach.frag).
//         AROUND: also tiles of other kinds at most so many away from one of KINDS, whose programs
//         read across the rim.
// Output: the point (tile_points.glsl).
#include "tap_kinds.glsl"
#include "tile_points.glsl"

uniform sampler2D reach;

int kind(ivec2 tile) {
    return int(texelFetch(reach, clamp(tile, ivec2(0), textureSize(reach, 0) - 1), 0).b);
}

bool is_drawn(ivec2 tile) {
    int found = kind(tile);
    if ((found & (KINDS)) == 0)
        for (int y = -AROUND; y <= AROUND; ++y)
            for (int x = -AROUND; x <= AROUND; ++x)
                found |= kind(tile + ivec2(x, y));
    return (found & (KINDS)) != 0;
}

void main() {
    ivec2 tiles = textureSize(reach, 0);
    ivec2 tile = tile_of_vertex(tiles);
    put_point(is_drawn(tile), tile, tiles);
}

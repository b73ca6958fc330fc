#version 450 core
// A square point on each tile of some KINDS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; reach (tap_around.frag).
//         OF: b for the tile's own kind, a for tiles around one of KINDS, too.
// Output: the point (tile_points.glsl).
#include "tap_kinds.glsl"
#include "tile_points.glsl"

uniform sampler2D reach;

void main() {
    ivec2 tiles = textureSize(reach, 0);
    ivec2 tile = tile_of_vertex(tiles);
    int found = int(texelFetch(reach, tile, 0).OF);
    put_point((found & (KINDS)) != 0, tile, tiles);
}

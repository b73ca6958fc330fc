#version 450 core
// A square point on each tile of some KINDS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; kinds: bits in the channel OF (blur_kinds.frag,
//         tap_around.frag).
// Output: the point (tile_points.glsl).
#include "kinds.glsl"
#include "tile_points.glsl"

uniform sampler2D kinds;

void main() {
    ivec2 tiles = textureSize(kinds, 0);
    ivec2 tile = tile_of_vertex(tiles);
    int found = int(texelFetch(kinds, tile, 0).OF);
    put_point((found & (KINDS)) != 0, tile, tiles);
}

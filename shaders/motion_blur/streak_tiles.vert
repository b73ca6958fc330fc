#version 450 core
// A square point on each tile of one KIND; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; longest (streak_neighbours.frag).
// Output: the point (tile_points.glsl).
#include "streak_kinds.glsl"
#include "tile_points.glsl"

uniform sampler2D longest;

void main() {
    ivec2 tiles = textureSize(longest, 0);
    ivec2 tile = tile_of_vertex(tiles);
    put_point(texelFetch(longest, tile, 0).z == KIND, tile, tiles);
}

#version 450 core
// A square point on each tile of some CLASSES; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; tile_classes: bits in the channel CHANNEL
//         (classify_ring_tiles.frag,
//         dilate_tile_classes.frag).
// Output: the point (tile_points.glsl).
#include "tile_points.glsl"

uniform sampler2D tile_classes;

void main() {
    ivec2 tiles = textureSize(tile_classes, 0);
    ivec2 tile = tile_of_vertex(tiles);
    int found = int(texelFetch(tile_classes, tile, 0).CHANNEL);
    put_point((found & (CLASSES)) != 0, tile, tiles);
}

#version 450 core
// A square point on each tile of one CLASS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; longest (tile_max_dilate.frag), which is of this frame only
//         with velocity discontinuities; frame (frame_streaks.comp).
// Output: the point (tile_points.glsl).
#include "motion_tile_classes.glsl"
#include "tile_points.glsl"

uniform sampler2D longest;
uniform sampler2D frame;

void main() {
    ivec2 tiles = textureSize(longest, 0);
    ivec2 tile = tile_of_vertex(tiles);
    bool known = may_be_complex(texelFetch(frame, ivec2(0), 0).xyz);
    put_point(known && texelFetch(longest, tile, 0).z == CLASS, tile, tiles);
}

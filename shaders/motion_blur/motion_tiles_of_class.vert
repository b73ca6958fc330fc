#version 450 core
// A square point on each tile of one CLASS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; longest (tile_max_dilate.frag), which is of this frame only
//         with velocity discontinuities; frame (frame_streaks.comp).
// Output: the point (tile_points.glsl).
#define EYE eye
#include "eyes.glsl"
#include "motion_tile_classes.glsl"
#include "tile_points.glsl"

uniform eye_image longest;
uniform eye_image frame;

ivec2 tiles = size_of(longest);
int eye = eye_of_vertex(tiles);

void main() {
    draw_in_layer();
    ivec2 tile = tile_of_vertex(tiles);
    bool known = may_be_complex(texel_of(frame, ivec2(0)).xyz);
    put_point(known && texel_of(longest, tile).z == CLASS, tile, tiles);
}

#version 450 core
// A square point on each tile of one CLASS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; dilated (coc_tile_dilate.frag). BESIDE: also tiles beside one of
//         that class, for what is read between its texels. UP_TO: and of classes after it, up to that.
//         IF_ANY: none, where no tile of the eye is of that class; most = the last class of each eye.
// Output: the point (tile_points.glsl); tile = what may reach it.
#define EYE eye
#include "eyes.glsl"
#include "tile_classes.glsl"
#include "tile_points.glsl"
#ifndef UP_TO
#define UP_TO CLASS
#endif

uniform eye_image dilated;
#ifdef IF_ANY
uniform eye_image most;
#endif

ivec2 tiles = size_of(dilated);
int eye = eye_of_vertex(tiles);

flat out vec4 tile;

bool drawn(ivec2 at) {
    bool found = false;
    for (int y = -BESIDE; y <= BESIDE; ++y)
        for (int x = -BESIDE; x <= BESIDE; ++x) {
            ivec2 other = clamp(at + ivec2(x, y), ivec2(0), tiles - 1);
            int other_class = int(texel_of(dilated, other).a);
            found = found || other_class >= CLASS && other_class <= UP_TO;
        }
    return found;
}

void main() {
    draw_in_layer();
    ivec2 at = tile_of_vertex(tiles);
    tile = texel_of(dilated, at);
    bool wanted = true;
#ifdef IF_ANY
    wanted = texel_of(most, ivec2(0)).x >= float(IF_ANY);
#endif
    put_point(wanted && drawn(at), at, tiles);
}

#version 450 core
// A square point on each tile of one CLASS; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; dilated (coc_tile_dilate.frag). BESIDE: also tiles beside one of
//         that class, for what is read between its texels. OR_ABOVE: and of classes after it.
// Output: the point (tile_points.glsl); tile = what may reach it.
#include "tile_classes.glsl"
#include "tile_points.glsl"

uniform sampler2D dilated;

flat out vec4 tile;

bool drawn(ivec2 at, ivec2 tiles) {
    bool found = false;
    for (int y = -BESIDE; y <= BESIDE; ++y)
        for (int x = -BESIDE; x <= BESIDE; ++x) {
            ivec2 other = clamp(at + ivec2(x, y), ivec2(0), tiles - 1);
            int other_class = int(texelFetch(dilated, other, 0).a);
#ifdef OR_ABOVE
            found = found || other_class >= CLASS;
#else
            found = found || other_class == CLASS;
#endif
        }
    return found;
}

void main() {
    ivec2 tiles = textureSize(dilated, 0);
    ivec2 at = tile_of_vertex(tiles);
    tile = texelFetch(dilated, at, 0);
    put_point(drawn(at, tiles), at, tiles);
}

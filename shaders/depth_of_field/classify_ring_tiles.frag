#version 450 core
// What is to be drawn on each tile: how it is blurred, and what the tiles around need of it.
//
// Input:  dilated (coc_tile_dilate.frag). MARGIN_PX: how much farther than discs reach half resolution
//         is read; SMALL_PX: RADIUS (px of image width) up to which discs are small.
// Output: the sum of its classes (vrcomfort/optics/tile_classes.py).
#include "coc.glsl"
#include "tile_dilate.glsl"

uniform sampler2D dilated;

out float tile_classes;

int class_of(vec4 tile) {
    float widest = max(-tile.r, tile.g);
    float least = max(max(tile.r, -tile.g), 0.0);
    if (widest <= 0.5)
        return SHARP;
    bool alike = is_alike(least, tile, 1.0);
    if (widest > SMALL_PX)
        return alike && least > SMALL_PX ? WIDE : LAYERED;
    return alike ? ALIKE : SMALL;
}

void main() {
    ivec2 last = textureSize(dilated, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    int found = class_of(texelFetch(dilated, middle, 0));
    int around = tiles_around();
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 there = texelFetch(dilated, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            int away = max(abs(x), abs(y));
            int tile_class = class_of(there);
            bool read = reaches(away, there);
            found |= tile_class != SHARP && read ? COLOUR_AND_COC : 0;
            bool halved = tile_class == LAYERED || tile_class == WIDE;
            found |= halved && read ? HALF_RESOLUTION : 0;
            found |= halved && away <= 1 ? LAYERS : 0;
        }
    tile_classes = float(found);
}

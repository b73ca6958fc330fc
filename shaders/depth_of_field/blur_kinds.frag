#version 450 core
// What is to be drawn on each tile: how it is blurred, and what the tiles around need of it.
//
// Input:  reach (defocus_reach.frag). MARGIN_PX: how much farther than discs reach half resolution
//         is read; SMALL_PX: RADIUS (px of image width) up to which discs are small.
// Output: the sum of its kinds (include/kinds.glsl).
#include "kinds.glsl"
#include "coc.glsl"
#include "tile_reach.glsl"

uniform sampler2D reach;

out float kinds;

int shown_as(vec4 tile) {
    float widest = max(-tile.r, tile.g);
    float least = max(max(tile.r, -tile.g), 0.0);
    if (widest <= 0.5)
        return COPIED;
    bool alike = is_alike(least, tile, 1.0);
    if (widest > SMALL_PX)
        return alike && least > SMALL_PX ? WIDE : LAYERED;
    return alike ? ALIKE : SMALL;
}

void main() {
    ivec2 last = textureSize(reach, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    int found = shown_as(texelFetch(reach, middle, 0));
    int far = reach_now();
    for (int y = -far; y <= far; ++y)
        for (int x = -far; x <= far; ++x) {
            vec4 there = texelFetch(reach, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            int away = max(abs(x), abs(y));
            int kind = shown_as(there);
            bool read = comes(away, there);
            found |= kind != COPIED && read ? POINTS : 0;
            bool halved = kind == LAYERED || kind == WIDE;
            found |= halved && read ? HALVES : 0;
            found |= halved && away <= 1 ? LAYERS : 0;
        }
    kinds = float(found);
}

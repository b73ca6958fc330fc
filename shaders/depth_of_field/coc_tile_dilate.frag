#version 450 core
// Lets every tile know what may reach it: the same summary over those of the tiles around whose discs
// come as far, or that its own discs reach.
//
// Input:  tiles (coc_tile_small_wide.frag; where only r and g are read, also coc_tile_min_max.frag).
// Output: the same four numbers over the neighbourhood; b over tiles from which small discs come.
//         RADIUS in px of image width.
#include "tile_dilate.glsl"

uniform sampler2D tiles;

out vec4 dilated;

void main() {
    ivec2 last = textureSize(tiles, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    vec4 own = texelFetch(tiles, middle, 0);
    dilated = vec4(1e4, -1e4, 0.0, 1e4);
    int around = tiles_around();
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 t = texelFetch(tiles, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            int away = max(abs(x), abs(y));
            if (!matters(away, own, t))
                continue;
            if (!reaches(away, vec4(t.b)))
                t.b = 0.0;
            dilated = vec4(min(dilated.r, t.r), max(dilated.gb, t.gb), min(dilated.a, t.a));
        }
}

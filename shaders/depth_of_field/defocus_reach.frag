#version 450 core
// Lets every tile know what may reach it: the same summary over those of the tiles around whose discs
// come as far, or that its own discs reach.
//
// Input:  tiles (defocus_tiles.frag; where only r and g are read, also defocus_range.frag).
// Output: the same four numbers over the neighbourhood; b over tiles from which small discs come.
//         RADIUS in px of image width.
#include "tile_reach.glsl"

uniform sampler2D tiles;

out vec4 reach;

void main() {
    ivec2 last = textureSize(tiles, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    vec4 own = texelFetch(tiles, middle, 0);
    reach = vec4(1e4, -1e4, 0.0, 1e4);
    int far = reach_now();
    for (int y = -far; y <= far; ++y)
        for (int x = -far; x <= far; ++x) {
            vec4 t = texelFetch(tiles, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            int away = max(abs(x), abs(y));
            if (!matters(away, own, t))
                continue;
            if (!comes(away, vec4(t.b)))
                t.b = 0.0;
            reach = vec4(min(reach.r, t.r), max(reach.gb, t.gb), min(reach.a, t.a));
        }
}

#version 450 core
// On which tiles very wide discs are drawn, and from which.
//
// Input:  reach (defocus_reach.frag). FAR_PX: RADIUS (px of image width) above which discs are very wide;
//         MARGIN_PX: how much farther than discs reach their texels are read.
// Output: the sum of HALVES and LAYERS (include/kinds.glsl).
#include "kinds.glsl"
#include "tile_reach.glsl"

uniform sampler2D reach;

out float kinds;

void main() {
    ivec2 last = textureSize(reach, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    int found = 0;
    int far = reach_now();
    for (int y = -far; y <= far; ++y)
        for (int x = -far; x <= far; ++x) {
            vec4 there = texelFetch(reach, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            int away = max(abs(x), abs(y));
            if (max(-there.r, there.g) <= FAR_PX)
                continue;
            found |= comes(away, there) ? HALVES : 0;
            found |= away <= 1 ? LAYERS : 0;
        }
    kinds = float(found);
}

#version 450 core
// On which tiles very wide discs are drawn, and from which.
//
// Input:  dilated (coc_tile_dilate.frag). COARSE_PX: RADIUS (px of image width) above which discs
//         are very wide;
//         MARGIN_PX: how much farther than discs reach their texels are read.
// Output: the sum of HALF_RESOLUTION and LAYERS (vrcomfort/optics/tile_classes.py).
#include "tile_dilate.glsl"

uniform sampler2D dilated;

out float tile_classes;

void main() {
    ivec2 last = textureSize(dilated, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    int found = 0;
    int around = tiles_around();
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 there = texelFetch(dilated, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            int away = max(abs(x), abs(y));
            if (max(-there.r, there.g) <= COARSE_PX)
                continue;
            found |= reaches(away, there) ? HALF_RESOLUTION : 0;
            found |= away <= 1 ? LAYERS : 0;
        }
    tile_classes = float(found);
}

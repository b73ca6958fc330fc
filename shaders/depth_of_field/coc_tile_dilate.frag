#version 450 core
// Lets every tile know what may reach it: over those of the tiles around whose discs come as far, or
// that its own discs reach.
//
// Input:  tiles (coc_tile_min_max.frag).
// Output: r, g = least and greatest signed RADIUS (px of image width); b = levels whose discs come here,
//         as bits; a = class of the tile (include/tile_classes.glsl).
#include "levels.glsl"
#include "tile_dilate.glsl"
#include "tile_classes.glsl"

uniform sampler2D tiles;

out vec4 dilated;

void main() {
    ivec2 last = textureSize(tiles, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    vec4 own = texelFetch(tiles, middle, 0);
    vec2 radii = vec2(1e4, -1e4);
    int levels = 0, all = 0;
    int around = tiles_around();
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 t = texelFetch(tiles, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            int away = max(abs(x), abs(y));
            if (!matters(away, own, t))
                continue;
            radii = vec2(min(radii.x, t.r), max(radii.y, t.g));
            levels |= reaches(away, t) ? int(t.a) : 0;
            all |= int(t.a);
        }
    bool sharp = max(-radii.x, radii.y) <= 0.5;
    bool wide = max(-own.r, own.g) > FADED * EXACT_PX && LEVELS > 1;
    int tile_class = sharp ? SHARP : (all & EDGE) != 0 ? LAYERED : wide ? WIDE : ONE_SURFACE;
    dilated = vec4(radii, float(levels & (EDGE - 1)), float(tile_class));
}

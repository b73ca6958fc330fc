#version 450 core
// Lets every tile know what may reach it: over those of the tiles around whose discs come as far, or
// that its own discs reach.
//
// Input:  tiles (coc_tile_min_max.frag). WITH_CUT: cut (cut_tiles.frag).
// Output: r = least signed RADIUS (px of image width); g = quadrants of the tile within whose reach a surface
//         ends, b = levels whose discs come here, as bits; a = class of the tile (include/tile_classes.glsl).
#include "eyes.glsl"
#include "levels.glsl"
#include "tile_dilate.glsl"
#include "tile_classes.glsl"

uniform eye_image tiles;
#ifdef WITH_CUT
uniform eye_image cut;
#endif

out vec4 dilated;

// The quadrants of a tile that have an end of a surface within reach, as bits; `ends` are those of a tile `apart`.
int quadrants_near(ivec2 apart, int ends, float reach_px) {
    const float SIDE = 0.5 * float(TILE);
    vec2 low = vec2(TILE * apart) + vec2((ends & 5) != 0 ? 0.0 : SIDE, (ends & 3) != 0 ? 0.0 : SIDE);
    vec2 high = vec2(TILE * apart) + SIDE + vec2((ends & 10) != 0 ? SIDE : 0.0, (ends & 12) != 0 ? SIDE : 0.0);
    int found = 0;
    for (int quadrant = 0; quadrant < (ends != 0 ? 4 : 0); ++quadrant) {
        vec2 first = SIDE * vec2(quadrant & 1, quadrant >> 1);
        vec2 gap = max(max(low - first - SIDE, first - high), 0.0);
        found |= length(gap) <= reach_px ? 1 << quadrant : 0;
    }
    return found;
}

void main() {
    ivec2 last = size_of(tiles) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    vec4 own = texel_of(tiles, middle);
    vec2 radii = vec2(1e4, -1e4);
    int levels = 0, quadrants = 0;
    int around = tiles_around();
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 t = texel_of(tiles, clamp(middle + ivec2(x, y), ivec2(0), last));
            float gap = gap_px(ivec2(x, y));
            if (!matters(gap, own, t))
                continue;
            radii = vec2(min(radii.x, t.r), max(radii.y, t.g));
            levels |= reaches(gap, t) ? int(t.a) & ((1 << LEVEL_BITS) - 1) : 0;
            quadrants |= quadrants_near(ivec2(x, y), int(t.a) >> LEVEL_BITS, max(widest_px(own), widest_px(t)));
        }
    bool sharp = max(-radii.x, radii.y) <= 0.5;
    bool wide = max(-own.r, own.g) > FADED * EXACT_PX && LEVELS > 1;
    int tile_class = sharp ? IN_FOCUS : quadrants != 0 ? COMPLEX : wide ? FAST_HALF_RESOLUTION : FAST;
#ifdef WITH_CUT
    tile_class = !sharp && texel_of(cut, middle).r > 0.0 ? CUT : tile_class;
#endif
    dilated = vec4(radii.x, float(quadrants), float(levels), float(tile_class));
}

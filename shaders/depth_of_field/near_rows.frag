#version 450 core
// Along rows: how far each tile is from the silhouette of something near, and how far near discs come.
//
// Input:  tiles (coc_tile_min_max.frag).
// Output: r = least distance (tiles) of a tile in this row in which something near ends, at most AWAY;
//         g, b = widest and least of the RADII (px) of near discs that may come here along the row, 0 without.
#include "eyes.glsl"
#include "levels.glsl"
#include "near.glsl"
#include "tile_dilate.glsl"

uniform eye_image tiles;

out vec4 row;

bool ends(vec4 t) {
    return t.r < -BEHIND_PX && (int(t.a) >> LEVEL_BITS) != 0;
}

void main() {
    ivec2 last = size_of(tiles) - 1, middle = ivec2(gl_FragCoord.xy);
    vec4 own = texel_of(tiles, middle);
    int around = tiles_around(), away = int(AWAY);
    for (int x = 0; x < away; ++x) {
        vec4 left = texel_of(tiles, ivec2(max(middle.x - x, 0), middle.y));
        vec4 right = texel_of(tiles, ivec2(min(middle.x + x, last.x), middle.y));
        away = ends(left) || ends(right) ? x : away;
    }
    float widest = 0.0, least = 1e4;
    for (int x = -around; x <= around; ++x) {
        vec4 t = texel_of(tiles, ivec2(clamp(middle.x + x, 0, last.x), middle.y));
        bool comes = t.r < FADES_PX - BEHIND_PX && -t.r + 1.0 >= gap_px(ivec2(x, 0));
        widest = comes ? max(widest, -t.r) : widest;
        least = comes ? min(least, max(-t.g, BEHIND_PX - FADES_PX)) : least;
    }
    row = vec4(float(away), widest, least, 0.0);
}

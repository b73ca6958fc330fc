#version 450 core
// Which tiles need what lies behind near things, and to which their discs come.
//
// Input:  tiles (coc_tile_min_max.frag); rows (near_rows.frag).
// Output: r, g = widest and least of the RADII (px) of near discs that may come here;
//         a = class (include/tile_classes.glsl).
//
// A near thing hides all behind it where its silhouette is farther than its disc is wide. What its rim shows
// of what is behind is blurred too: that is drawn as far again. Farther in, nothing is drawn apart.
#include "eyes.glsl"
#include "near.glsl"
#include "tile_dilate.glsl"
#include "tile_classes.glsl"

uniform eye_image tiles;
uniform eye_image rows;

out vec4 near_tile;

void main() {
    ivec2 last = size_of(rows) - 1, middle = ivec2(gl_FragCoord.xy);
    float own_px = -texel_of(tiles, middle).r;
    int around = tiles_around();
    float widest = 0.0, least = 1e4;
    for (int y = -around; y <= around; ++y) {
        vec4 t = texel_of(rows, ivec2(middle.x, clamp(middle.y + y, 0, last.y)));
        bool comes = t.g > 0.0 && pixel_aspect * t.g + 1.0 >= gap_px(ivec2(0, y));
        widest = comes ? max(widest, t.g) : widest;
        least = comes ? min(least, t.b) : least;
    }
    float away = AWAY;
    int within = widest > 0.0 ? int(AWAY) - 1 : -1;
    for (int y = 0; y <= within; ++y) {
        float below = texel_of(rows, ivec2(middle.x, max(middle.y - y, 0))).r;
        float above = texel_of(rows, ivec2(middle.x, min(middle.y + y, last.y))).r;
        away = min(away, length(vec2(min(below, above), float(y))));
        within = min(within, int(away));
    }
    float away_px = float(TILE) * max(away - 1.0, 0.0) / max(pixel_aspect, 1.0);
    bool needs_behind = own_px > BEHIND_PX && away_px <= 2.0 * own_px;
    // The discs of pixels where nothing is drawn apart must not meet tiles where it is.
    bool is_near = widest > 0.0 && away_px <= 3.0 * widest + 2.0 * float(TILE);
    near_tile = vec4(widest, least, 0.0, float(is_near && needs_behind ? BEHIND : is_near ? NEAR : 0));
}

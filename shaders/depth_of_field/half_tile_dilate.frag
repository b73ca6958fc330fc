#version 450 core
// Lets every tile know how far discs of nearer things come to it.
//
// Input:  tiles (half_tiles.frag); widest: no RADIUS (px) of the image is larger.
// Output: r = widest RADIUS of what is in front of the focus and reaches the tile, 0 for none (px of image
//         width); g = widest of the tile, those beside it, and r; b = narrowest of what r is the widest of; a =
//         class (include/tile_classes.glsl).
// SLACK_PX: a tile's ranges are of texels of two pixels, and read bilinearly.
#include "eyes.glsl"
#include "tile_dilate.glsl"
#include "tile_classes.glsl"

uniform eye_image tiles;

out vec4 dilated;

void main() {
    ivec2 last = size_of(tiles) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    vec4 own = texel_of(tiles, middle);
    float own_px = max(-own.r, own.g);
    bool ends = false, small_beside = false;
    float front_px = 0.0, least_px = 1e4, widest_px = 0.0;
    float most_px = max(pixel_aspect, 1.0) * min(MAX_RADIUS_PX, texel_of(widest, ivec2(0)).r) + SLACK_PX;
    int around = int(most_px / float(TILE)) + 1;
    for (int y = -around; y <= around; ++y) {
        float row_px = gap_px(ivec2(0, y));
        int across = int(sqrt(max(most_px * most_px - row_px * row_px, 0.0)) / float(TILE)) + 1;
        for (int x = -across; x <= across; ++x) {
            vec4 t = texel_of(tiles, clamp(middle + ivec2(x, y), ivec2(0), last));
            float reach_px = max(pixel_aspect, 1.0) * max(-t.r, 0.0) + SLACK_PX;
            float gap = gap_px(ivec2(x, y));
            bool reaches = gap <= reach_px;
            float either_px = max(pixel_aspect, 1.0) * max(own_px, max(-t.r, t.g)) + SLACK_PX;
            ends = ends || gap <= either_px && (int(t.a) & HAS_END) != 0;
            front_px = reaches ? max(front_px, -t.r) : front_px;
            least_px = reaches ? min(least_px, -t.b) : least_px;
            bool beside = max(abs(x), abs(y)) <= 1;
            small_beside = small_beside || beside && (int(t.a) & HAS_SMALL) != 0;
            widest_px = beside ? max(widest_px, max(-t.r, t.g)) : widest_px;
        }
    }
    widest_px = max(widest_px, front_px);
    bool has_small = (int(own.a) & HAS_SMALL) != 0;
    int tile_class = widest_px <= 0.5 ? IN_FOCUS : ends ? (has_small ? COMPLEX : COMPLEX_HALF_RESOLUTION)
                                                        : (small_beside ? FAST : FAST_HALF_RESOLUTION);
    dilated = vec4(front_px, widest_px, min(least_px, front_px), float(tile_class));
}

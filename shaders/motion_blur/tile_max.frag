#version 450 core
// The longest half velocity of each tile (McGuire et al. 2012, TileMax), the one that crosses it, and
// how steep streaks change.
//
// Input:  ROWS (even): velocity, of which a texel sums up TILE (even) columns of ROWS rows; else source:
//         the result of that, of which a texel sums up STRIPS.
// Output: tile_max: xy = longest half velocity in the tile, px, without the limit; z = length of the
//         shortest; w = steepness: the most by which half velocities of two pixels that touch at a
//         corner differ.
//         crossing = the half velocity whose end lies farthest beside the longest one's line, px,
//         without the limit; rows where streaks nowhere jump are not asked. A slow object before a
//         faster back may have no tile of its own in which it is the longest.
//
// Every second pixel is read, as on a chessboard: no line is so thin that it is missed, only what is
// a single pixel.
#include "eyes.glsl"
#include "where.glsl"
#include "velocity.glsl"
#include "motion_tile_classes.glsl"

layout(location = 0) out vec4 tile_max;
layout(location = 1) out vec2 crossing;

#ifdef ROWS
#include "half_velocity.glsl"

ivec2 first = ivec2(gl_FragCoord.xy) * ivec2(TILE, ROWS);
ivec2 last = size_of(velocity) - 1;

vec2 at(int x, int y) {
    return velocity_at(clamp(first + ivec2(x, y), ivec2(0), last));
}

float squared(vec2 v) {
    return dot(v, v);
}

// Even rows have their even columns read, odd rows their odd ones. Each pixel is compared with the
// four at its corners: those of the row above, and of odd rows one column further left.
void main() {
    vec2 left[ROWS];
    for (int y = 1; y < ROWS; y += 2)
        left[y] = at(-1, y);
    vec2 longest = vec2(0.0);
    float least = 1e30, steepest = 0.0;
    for (int x = 0; x < TILE; x += 2) {
        vec2 above = at(x, 0);
        for (int y = 0; y < ROWS; ++y) {
            bool odd = (y & 1) == 1;
            vec2 v = above;
            above = at(odd ? x : x + 1, y + 1);
            longest = squared(v) > squared(longest) ? v : longest;
            least = min(least, squared(v));
            steepest = max(steepest, squared(above - v));
            if (odd) {
                steepest = max(steepest, squared(above - left[y]));
                left[y] = v;
            } else {
                steepest = max(steepest, squared(left[y + 1] - v));
            }
        }
    }
    tile_max = 0.5 * shutter_fraction * vec4(longest, sqrt(least), sqrt(steepest));
    crossing = vec2(0.0);
    WHERE (tile_max.w > jump_px(tile_max.z))
        for (int i = 0; i < TILE * ROWS / 2; ++i) {
            int y = i / (TILE / 2), x = 2 * (i % (TILE / 2)) + (y & 1);
            crossing = farther_beside(tile_max.xy, crossing, at(x, y));
        }
    crossing *= 0.5 * shutter_fraction;
}
#else
uniform eye_image source;
uniform eye_image source_crossing;

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * ivec2(1, STRIPS);
    int last = size_of(source).y - 1;
    tile_max = texel_of(source, first);
    for (int i = 1; i < STRIPS; ++i) {
        vec4 s = texel_of(source, ivec2(first.x, min(first.y + i, last)));
        tile_max.xy = dot(s.xy, s.xy) > dot(tile_max.xy, tile_max.xy) ? s.xy : tile_max.xy;
        tile_max.z = min(tile_max.z, s.z);
        tile_max.w = max(tile_max.w, s.w);
    }
    crossing = vec2(0.0);
    for (int i = 0; i < STRIPS; ++i) {
        ivec2 strip = ivec2(first.x, min(first.y + i, last));
        crossing = farther_beside(tile_max.xy, crossing, texel_of(source, strip).xy);
        crossing = farther_beside(tile_max.xy, crossing, texel_of(source_crossing, strip).xy);
    }
}
#endif

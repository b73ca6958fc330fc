#version 450 core
// What can reach a tile (McGuire et al. 2012, NeighborMax): of the half velocities around it that are
// long enough to come here, the longest and the one that crosses it.
//
// Input:  tile_max, tile_max_crossing (tile_max.frag); frame (frame_streaks.comp), which says how far one
//         has to look. Drawn in frames in which a tile may be COMPLEX (frame_of_streaks.vert).
// Output: longest: xy = longest half velocity that reaches this tile, at most max_radius_px;
//         z = which pass the tile needs (motion_tile_classes.glsl); w = in tiles of class COMPLEX, steepness
//         of the steepest tile within that reach.
//         crossing: in tiles of class COMPLEX, of the half velocities that reach the tile the one whose
//         end lies farthest beside the longest one's line, at most max_radius_px; 0 where it
//         does not go clearly another way (motion_tile_classes.glsl, crosses).
#include "eyes.glsl"
#include "where.glsl"
#include "velocity.glsl"
#include "motion_tile_classes.glsl"

uniform eye_image tile_max;
uniform eye_image tile_max_crossing;
uniform eye_image frame;
uniform float max_radius_px;

layout(location = 0) out vec4 longest;
layout(location = 1) out vec2 crossing;

ivec2 tile = ivec2(gl_FragCoord.xy);
ivec2 last = size_of(tile_max) - 1;

// Pixels between this tile and the one `step` away: 0 for neighbours.
float gap_px(ivec2 step) {
    return float(max(max(abs(step.x), abs(step.y)) - 1, 0) * TILE);
}

// How many tiles away a half velocity may begin and come here.
int rings(float reach_px) {
    return int(min(reach_px, max_radius_px)) / TILE + 1;
}

ivec2 place(ivec2 step) {
    return clamp(tile + step, ivec2(0), last);
}

vec4 at(ivec2 step) {
    return texel_of(tile_max, place(step));
}

// A half velocity of the tile that is `step` away, shortened; 0 where it does not come here.
vec2 reaching(vec2 half_velocity, ivec2 step) {
    vec2 s = shorten(half_velocity, max_radius_px);
    return length(s) >= gap_px(step) ? s : vec2(0.0);
}

void main() {
    vec2 around = vec2(0.0);
    float steepness = 0.0;
    int far = rings(texel_of(frame, ivec2(0)).x);
    for (int y = -far; y <= far; ++y)
        for (int x = -far; x <= far; ++x) {
            vec4 there = at(ivec2(x, y));
            vec2 s = reaching(there.xy, ivec2(x, y));
            around = dot(s, s) > dot(around, around) ? s : around;
            steepness = max(steepness, there.w);
        }
    // Where nothing is steep as far as the frame's longest streak comes, nothing is within this reach.
    float shortest = at(ivec2(0)).z;
    bool is_complex = class_of(around, shortest, steepness) == COMPLEX;
    far = rings(length(around));
    WHERE (is_complex) {
        steepness = 0.0;
        for (int y = -far; y <= far; ++y)
            for (int x = -far; x <= far; ++x)
                steepness = max(steepness, at(ivec2(x, y)).w);
    }
    longest = vec4(around, class_of(around, shortest, steepness), steepness);
    crossing = vec2(0.0);
    WHERE (longest.z == COMPLEX)
        for (int y = -far; y <= far; ++y)
            for (int x = -far; x <= far; ++x) {
                ivec2 step = ivec2(x, y);
                vec2 second = texel_of(tile_max_crossing, place(step)).xy;
                crossing = farther_beside(around, crossing, reaching(at(step).xy, step));
                crossing = farther_beside(around, crossing, reaching(second, step));
            }
    if (!crosses(crossing, around))
        crossing = vec2(0.0);
}

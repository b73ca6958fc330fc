#version 450 core
// What can reach a tile (McGuire et al. 2012, NeighborMax): the longest half streak around it, of
// those that are long enough to come here.
//
// Input:  tiles (streak_tiles.frag); peak = the longest half streak of all frames so far, which
//         says how far one has to look.
// Output: xy = longest half streak that reaches this tile, at most radius_limit_px; z = which pass
//         the tile needs (streak_kinds.glsl); w = steepness of the steepest tile within that reach.
#include "velocity.glsl"
#include "streak_kinds.glsl"

uniform sampler2D tiles;
uniform sampler2D peak;
uniform float radius_limit_px;

out vec4 longest;

ivec2 tile = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(tiles, 0) - 1;

// Pixels between this tile and the one `step` away: 0 for neighbours.
float gap_px(ivec2 step) {
    return float(max(max(abs(step.x), abs(step.y)) - 1, 0) * TILE);
}

// How many tiles away a half streak may begin and come here.
int rings(float reach_px) {
    return int(min(reach_px, radius_limit_px)) / TILE + 1;
}

vec4 at(ivec2 step) {
    return texelFetch(tiles, clamp(tile + step, ivec2(0), last), 0);
}

void main() {
    vec2 around = vec2(0.0);
    int far = rings(texelFetch(peak, ivec2(0), 0).r);
    for (int y = -far; y <= far; ++y)
        for (int x = -far; x <= far; ++x) {
            vec2 s = shorten(at(ivec2(x, y)).xy, radius_limit_px);
            bool comes_here = length(s) >= gap_px(ivec2(x, y));
            around = comes_here && dot(s, s) > dot(around, around) ? s : around;
        }
    float steepness = 0.0;
    far = rings(length(around));
    for (int y = -far; y <= far; ++y)
        for (int x = -far; x <= far; ++x)
            steepness = max(steepness, at(ivec2(x, y)).w);
    longest = vec4(around, kind_of(around, at(ivec2(0)).z, steepness), steepness);
}

#version 450 core
// The discs of near things at half resolution, and who hides whom among them.
//
// Input:  light, radius: NEAR_LEVELS levels of what is near (near_layer.frag); tile (near_tiles.frag).
//         EACH_NEAR_LEVEL(f): f(1) f(2) … of them (include/levels.glsl).
// Output: rgb and opacity, premultiplied, about the middles of texels of level 1.
//
// Where p is near, its surface is the mean over p's own disc of what is not nearer: where nothing is, all
// behind is seen. Within a surface that is exactly 1. What is nearer scatters over it, and over a p that is
// not near: a q adds 1 / area(q). Every texel of a disc counts once, on its level (include/levels.glsl).
#include "coc.glsl"
#include "discs.glsl"
#include "finite.glsl"
#include "levels.glsl"
#include "near.glsl"

flat in vec4 tile;

uniform sampler2D light[NEAR_LEVELS];   // of level 1, 2, …
uniform sampler2D radius[NEAR_LEVELS];

out vec4 over_all;

vec4 p = texelFetch(light[0], ivec2(gl_FragCoord.xy), 0);
float own_radius = p.a > 0.0 ? texelFetch(radius[0], ivec2(gl_FragCoord.xy), 0).r / p.a : 0.0;

vec4 own = vec4(0.0);        // of p's surface
vec4 nearer_only = vec4(0.0);  // of what is nearer than p
vec4 all = vec4(0.0);        // of all that is near

// Part of a disc that is drawn on a level: the first has those of pixels, too.
float part_on(int level, float radius_px) {
    return level > 1 ? level_part(level, radius_px) : 1.0 - coarser_part(1, radius_px);
}

float texels_of(float radius_px, float texel_px) {
    return grid_radius_px(disc_texels(sqrt(max(radius_px * radius_px - ENLARGED_PX2, 0.0)), texel_px));
}

void gather(sampler2D light_of, sampler2D radius_of, int level) {
    float texel_px = float(1 << level);
    float own_part = p.a > 0.0 ? part_on(level, -own_radius) : 0.0;
    float widest = level < LEVELS - 1 ? min(tile.r, widest_on(level)) : tile.r;
    bool comes = level == 1 ? tile.g < widest_on(1) || LEVELS == 2 : coarser_part(level - 1, tile.r) > 0.0;
    comes = comes && (level == LEVELS - 1 || tile.g < widest_on(level));
    float own_texels = texels_of(-own_radius, texel_px);
    float most = max(own_part > 0.0 ? own_texels : 0.0, comes ? texels_of(widest, texel_px) : 0.0);
    float reach = most + 0.5 * RIM_PX;
    vec2 place = 2.0 * gl_FragCoord.xy / texel_px - 0.5;
    float rows = reach * pixel_aspect;
    int top = comes || own_part > 0.0 ? int(floor(place.y + rows)) : -1000000;
    ivec2 last = textureSize(light_of, 0) - 1;
    vec4 found = vec4(0.0), over = vec4(0.0), over_own = vec4(0.0);
    float seen = 0.0;
    for (int y = int(ceil(place.y - rows)); y <= top; ++y) {
        float row = (float(y) - place.y) / pixel_aspect;
        float cells = sqrt(max(reach * reach - row * row, 0.0));
        int right = int(floor(place.x + cells));
        for (int x = int(ceil(place.x - cells)); x <= right; ++x) {
            ivec2 at = clamp(ivec2(x, y), ivec2(0), last);
            vec4 q = texelFetch(light_of, at, 0);
            float away = length(vec2(float(x) - place.x, row));
            float share = disc_share(away, own_texels);
            if (q.a > 0.0) {
                float q_radius = texelFetch(radius_of, at, 0).r / q.a;
                float is_nearer = nearer(own_radius, q_radius);
                vec4 comes_here = apart(q_radius) * part_on(level, -q_radius) * disc_share(away, texels_of(-q_radius, texel_px)) * q;
                over += comes_here;
                over_own += is_nearer * comes_here;
                found += (1.0 - is_nearer) * share * q;
                seen -= is_nearer * share * q.a;
            }
            seen += share;
        }
    }
    own += own_part > 0.0 && seen > 1e-5 ? own_part * found / seen : vec4(0.0);
    all += over / (PI * pixel_aspect);
    nearer_only += over_own / (PI * pixel_aspect);
}

// Part of p that is drawn apart, or goes on beside what is: a straight end takes 3 texels of 9.
float part_apart() {
    float found = 3.0 * apart(own_radius);
    int around = p.a > 0.0 && found < 3.0 ? 1 : -1;
    ivec2 last = textureSize(light[0], 0) - 1;
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            ivec2 at = clamp(ivec2(gl_FragCoord.xy) + ivec2(x, y), ivec2(0), last);
            float q_part = texelFetch(light[0], at, 0).a;
            found += q_part > 0.0 ? q_part * apart(texelFetch(radius[0], at, 0).r / q_part) : 0.0;
        }
    return p.a * min(found / 3.0, 1.0);
}

// Opacity adds up to 1 at most.
vec4 limited(vec4 sum) {
    return sum / max(sum.a, 1.0);
}

void main() {
#define GATHER(level) gather(light[level - 1], radius[level - 1], level);
    EACH_NEAR_LEVEL(GATHER)
    vec4 over = limited(nearer_only);
    over_all = min(mix(limited(all), over + (1.0 - over.a) * limited(own), part_apart()), HALF_MAX);
}

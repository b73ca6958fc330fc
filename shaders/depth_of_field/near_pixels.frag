#version 450 core
// Small discs of near things, summed over pixels: the nearer surface's, and who hides whom among them.
//
// Input:  colour_and_coc (colour_and_coc.frag), still with near things; next, next_depth (near_layer.frag); tile (near_tiles.frag); drawn on tiles of class
//         NEAR.
// Output: rgb and opacity, premultiplied: what near_gather.frag leaves to this (pixels_part of near.glsl). It lies behind
//         what that sums (near_over.glsl).
//
// A pixel is the mean over its own disc of what is neither nearer nor well behind it; what is nearer scatters over it,
// and what is farther is seen past it. A q adds 1 / area(q).
#include "eyes.glsl"
#include "coc.glsl"
#include "coverage.glsl"
#include "discs.glsl"
#include "finite.glsl"
#include "near.glsl"
#include "where.glsl"

flat in vec4 tile;

uniform eye_image colour_and_coc;
uniform eye_image next;
uniform eye_image next_depth;

out vec4 over;

// How far from what is drawn apart p goes on beside it, as far as a straight end is seen.
const float BESIDE_PX = 2.75;

ivec2 pixel = ivec2(gl_FragCoord.xy);
ivec2 last = size_of(colour_and_coc) - 1;
vec4 p = texel_of(colour_and_coc, pixel);

// How the radius of p's surface grows, per pixel.
float step_to(ivec2 to) {
    return texel_of(colour_and_coc, clamp(pixel + to, ivec2(0), last)).a - p.a;
}

// Weight of a pixel so far away in what is read of half the image here, between texels.
float read_here(ivec2 off) {
    ivec2 texels = ((pixel + off) >> 1) - (pixel >> 1), side = 2 * (pixel & 1) - 1;
    vec2 share = mix(mix(vec2(0.0), vec2(0.25), equal(texels, side)), vec2(0.75), equal(texels, ivec2(0)));
    return share.x * share.y;
}

// Light of a near pixel and how much of it is covered, as near_layer.frag takes it.
vec4 without_next(vec4 q, ivec2 at) {
    vec4 found = vec4(q.rgb, 1.0);
    WHERE (coverage_of(q.a) < 1.0 && near_part(q.a) > 0.0) {
        vec3 beside = finite(texel_of(next, at).rgb);
        float less = (1.0 - coverage_of(q.a)) * (1.0 - lamp_part(vec4(beside, 0.0)));
        found -= texel_of(next_depth, at).r < 1.0 ? less * vec4(beside, 1.0) : vec4(0.0);
    }
    return max(found, 0.0);
}

void main() {
    float is_own = 3.0 * apart(p.a);
    float own_grid = grid_radius_px(max(-p.a, 0.5));
    float widest_px = tile.g < PIXELS_PX ? min(tile.r, PIXELS_PX) : 0.0;
    float reach = widest_px > 0.0 ? grid_radius_px(widest_px) + 0.5 * RIM_PX : -1.0;
    int rows = int(floor(reach * pixel_aspect));
    vec2 slope = vec2(lesser(step_to(ivec2(1, 0)), -step_to(ivec2(-1, 0))),
                      lesser(step_to(ivec2(0, 1)), -step_to(ivec2(0, -1))));
    vec4 own = vec4(0.0), all = vec4(0.0), nearer_only = vec4(0.0), farther_only = vec4(0.0);
    float seen = 0.0;
    vec2 left = vec2(0.0);  // of p's surface, what near_gather.frag leaves to this, and all
    for (int y = -rows; y <= rows; ++y) {
        float row = float(y) / pixel_aspect;
        int cells = int(sqrt(max(reach * reach - row * row, 0.0)));
        for (int x = -cells; x <= cells; ++x) {
            ivec2 to = pixel + ivec2(x, y), at = clamp(to, ivec2(0), last);
            vec4 q = texel_of(colour_and_coc, at);
            // The image's border goes on, but no lamp.
            vec4 light = (at == to ? 1.0 : 1.0 - lamp_part(q)) * without_next(q, at);
            float away = sqrt(float(x * x) + row * row), share = disc_share(away, own_grid);
            float own_px = clamp(p.a + dot(slope, vec2(x, y)), 2.0 * p.a, 0.25 * p.a);
            float is_nearer = nearer(own_px, q.a), is_farther = farther(own_px, q.a);
            vec4 comes = apart(q.a) * pixels_part(q.a) * disc_share(away, grid_radius_px(max(-q.a, 0.5))) * light;
            float as_own = (1.0 - is_nearer - is_farther) * near_part(q.a);
            own += as_own * share * light;
            left += as_own * read_here(ivec2(x, y)) * vec2(pixels_part(q.a), 1.0);
            seen += (1.0 - is_nearer) * share;
            is_own += apart(q.a) * clamp(BESIDE_PX - away, 0.0, 1.0);
            all += comes;
            nearer_only += is_nearer * comes;
            farther_only += is_farther * comes;
        }
    }
    float area = PI * pixel_aspect;
    own *= left.x / max(left.y * seen, 1e-4);
    over = past(upon(limited(nearer_only / area), own), farther_only / area);
    over = min(mix(limited(all / area), over, coverage_of(p.a) * near_part(p.a) * min(is_own / 3.0, 1.0)), HALF_MAX);
}

#version 450 core
// Depth of field by gathering what other pixels would scatter here, with who hides whom.
//
// Input:  colour_and_coc (colour_and_coc.frag; signed CoC RADIUS in px of image width, negative in front
//         of the focus); layers_1, layers_2 … (layers.frag): what wide discs are made of; tile: what may
//         reach it (coc_tile_dilate.frag).
// Output: the blurred image, linear HDR, full resolution.
//
// A pixel p looks for two kinds of neighbours q, told apart by their CoC, which orders depth:
//
//   background  q is p's own surface or behind it. A lens sample u sees p's surface at p + u r_p, or
//               past its silhouette something behind: the average over p's OWN disc. Where q is p's
//               surface, q's own disc says how much of q lands here, so that lamps keep their light.
//   foreground  q is nearer than p. Its disc covers p if it is wide enough: q adds 1 / area(q) to an
//               opacity, and the foreground is composited over the background. A sharp q covers no
//               neighbour, so sharp silhouettes do not bleed; a blurred near q spreads over a sharp p.
//
//        disc of a nearer q       On one slanted surface both kinds give the same answer, so
//           ___                   where the line between them is drawn does not show.
//         /     \                 The background is normalised (a constant image stays constant),
//     ---|---p---|--- background  the foreground's opacity is absolute and stops at 1.
//         \ ___ /
//
// Every texel of a disc counts once, on the level (include/levels.glsl) on which it has not too many: no
// sample lies between two others, so that lamps make no beads. No noise, hence the same
// kernel in both eyes. Carnegie & Rhee 2015, Algorithm 1; gathering after
// Jimenez 2014, "Next generation post processing in Call of Duty: Advanced Warfare".
//
// Renderers on the CPU run both sides of every branch, but no loop that no pixel wants: so what few
// pixels want is a loop.
#include "coc.glsl"
#include "discs.glsl"
#include "levels.glsl"
#include "layers.glsl"

flat in vec4 tile;

uniform sampler2D colour_and_coc;
#if LEVELS > 1
uniform usampler2D layers_1;
#endif
#if LEVELS > 2
uniform usampler2D layers_2;
#endif
#if LEVELS > 3
uniform usampler2D layers_3;
#endif
#if LEVELS > 4
uniform usampler2D layers_4;
#endif

out vec4 blurred;

ivec2 pixel = ivec2(gl_FragCoord.xy);
vec4 p = texelFetch(colour_and_coc, pixel, 0);
float own_px = abs(p.a);

vec4 background = vec4(0.0);  // rgb * weight, weight
vec4 foreground = vec4(0.0);  // rgb * opacity, opacity

// How many texels to either side a row has within reach.
float cells_of(float row, float reach) {
    return sqrt(max(reach * reach - row * row, 0.0));
}

// All pixels around: the background where `own`, and the foreground that is drawn on pixels.
void gather_pixels(float own, float foreground_px) {
    float slack_px = slack_of(own_px);
    float widest_px = max(own > 0.0 ? own_px + slack_px : 0.0, foreground_px);
    float reach = widest_px > 0.0 ? grid_radius_px(widest_px) + 0.5 * RIM_PX : -1.0;
    int rows = int(floor(reach * pixel_aspect));
    float per_margin = 1.0 / margin_px(p.a);
    ivec2 last = textureSize(colour_and_coc, 0) - 1;
    vec4 under = vec4(0.0), over = vec4(0.0);
    for (int y = -rows; y <= rows; ++y) {
        float row = float(y) / pixel_aspect;
        int cells = int(cells_of(row, reach));
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texelFetch(colour_and_coc, clamp(pixel + ivec2(x, y), ivec2(0), last), 0);
            float away = sqrt(float(x * x) + row * row);
            float radius = abs(q.a);
            float is_nearer = clamp((p.a - q.a) * per_margin - 1.0, 0.0, 1.0);  // nearer()
            float as_own = clamp(radius, own_px - slack_px, own_px + slack_px);
            float share = disc_share(away, grid_radius_px(mix(as_own, radius, is_nearer)));
            under += (1.0 - is_nearer) * share * vec4(q.rgb, 1.0);
            over += (radius > 0.5 ? is_nearer * (1.0 - coarser_part(0, radius)) : 0.0)
                  * share * vec4(q.rgb, 1.0);
        }
    }
    background += own > 0.0 ? own / max(under.a, 1e-6) * under : vec4(0.0);
    foreground += over / (PI * pixel_aspect);
}

// All texels of a level around: the background where `own`, and the foreground that is drawn there.
void gather_texels(usampler2D layers, int level, float own, float foreground_px) {
    float texel_px = float(1 << level);
    float own_texels = grid_radius_px(disc_texels(own_px, texel_px));
    float widest = max(own > 0.0 ? own_texels : 0.0,
                       foreground_px > 0.0 ? grid_radius_px(disc_texels(foreground_px, texel_px)) : 0.0);
    float reach = widest > 0.0 ? widest + 0.5 * RIM_PX : -1.0;
    float rows = reach * pixel_aspect;
    vec2 place = gl_FragCoord.xy / texel_px - 0.5;
    int top = reach > 0.0 ? int(floor(place.y + rows)) : -1000000;
    ivec2 last = textureSize(layers, 0) - 1;
    vec4 under = vec4(0.0), over = vec4(0.0);
    for (int y = int(ceil(place.y - rows)); y <= top; ++y) {
        float row = (float(y) - place.y) / pixel_aspect;
        float cells = cells_of(row, reach);
        int right = int(floor(place.x + cells));
        for (int x = int(ceil(place.x - cells)); x <= right; ++x) {
            Layers q = unpack_layers(texelFetch(layers, clamp(ivec2(x, y), ivec2(0), last), 0));
            float away = length(vec2(float(x) - place.x, row));
            float own_share = disc_share(away, own_texels);
            float front = nearer(p.a, q.front.a), back = nearer(p.a, q.back.a);
            under += own_share * ((1.0 - front) * q.coverage * vec4(q.front.rgb, 1.0)
                                + (1.0 - back) * (1.0 - q.coverage) * vec4(q.back.rgb, 1.0));
            float front_px = abs(q.front.a), back_px = abs(q.back.a);
            over += front * q.coverage * level_part(level, front_px)
                  * disc_share(away, grid_radius_px(disc_texels(front_px, texel_px))) * vec4(q.front.rgb, 1.0);
            over += back * (1.0 - q.coverage) * level_part(level, back_px)
                  * disc_share(away, grid_radius_px(disc_texels(back_px, texel_px))) * vec4(q.back.rgb, 1.0);
        }
    }
    // What is behind p may not be in sight at all.
    background += own > 0.0 ? own * (under.a > 1e-4 ? under / under.a : vec4(p.rgb, 1.0)) : vec4(0.0);
    foreground += over / (PI * pixel_aspect);
}

// The widest foreground disc of a level that may come here, 0 for none.
float foreground_of(int level) {
    bool there = tile.r < p.a - margin_px(p.a) && (int(tile.b) & (1 << level)) != 0;
    float widest = level < LEVELS - 1 ? EXACT_PX * float(1 << level) : 1e4;
    return there ? min(max(-tile.r, p.a), widest) : 0.0;
}

float own_part(int level) {
    return own_px > 0.5 ? level_part(level, own_px) : 0.0;
}

void main() {
    background = own_px <= 0.5 ? vec4(p.rgb, 1.0) : vec4(0.0);
    gather_pixels(own_part(0), foreground_of(0));
#if LEVELS > 1
    gather_texels(layers_1, 1, own_part(1), foreground_of(1));
#endif
#if LEVELS > 2
    gather_texels(layers_2, 2, own_part(2), foreground_of(2));
#endif
#if LEVELS > 3
    gather_texels(layers_3, 3, own_part(3), foreground_of(3));
#endif
#if LEVELS > 4
    gather_texels(layers_4, 4, own_part(4), foreground_of(4));
#endif
    vec3 over = foreground.a > 0.0 ? foreground.rgb / foreground.a : vec3(0.0);
    vec3 all = mix(background.rgb / background.a, over, min(foreground.a, 1.0));
    blurred = vec4(own_px <= 0.5 && foreground.a <= 0.0 ? p.rgb : min(all, 65504.0), 1.0);
}

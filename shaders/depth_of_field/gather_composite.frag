#version 450 core
// Depth of field by gathering what other pixels would scatter here, with who hides whom.
//
// Input:  colour (for exact copies), colour_and_coc (signed CoC radius in a), dilated (what may reach
//         this tile; not with ONE_SURFACE), wide_background and wide_foreground (half resolution;
//         only with WIDE_LAYERS). Radii in pixels of image width, negative in front of the focus.
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
// Discs up to SMALL_PX are summed over every pixel. Wider ones come from half resolution where the
// texels around are on p's surface; elsewhere (thin things, rims) p walks its own rings. Where
// discs are very wide these would lie far apart, and one such texel will do. No noise, hence the same
// kernel in both eyes. Carnegie & Rhee 2015, Algorithm 1; gathering after
// Jimenez 2014, "Next generation post processing in Call of Duty: Advanced Warfare".
//
// Renderers on the CPU run both sides of every branch, but no loop that no pixel wants. So what few
// pixels want is a loop: of no taps, or `for (bool on = wanted; on; on = false)` around one. And each
// class of tile (vrcomfort/optics/tile_classes.py) has a program: ONE_SURFACE with small discs
// alone, several
// surfaces with small discs, and WIDE_LAYERS with everything.
#include "coc.glsl"
#include "gather.glsl"

uniform sampler2D colour;
uniform sampler2D colour_and_coc;
#ifndef ONE_SURFACE
uniform sampler2D dilated;
#endif

out vec4 blurred;

// Taps of a ring pattern lie about this far apart (px) until RINGS is reached.
const float SPACING_PX = 1.25;

ivec2 pixel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(colour_and_coc, 0) - 1;
vec4 p = texelFetch(colour_and_coc, pixel, 0);
float own_px = abs(p.a);

vec4 background = vec4(0.0);   // rgb * weight, weight
vec4 foreground = vec4(0.0);  // rgb * opacity, opacity

// How many pixels to either side a row has within reach.
int cells_of(float row_px, float reach_px) {
    return int(sqrt(max(reach_px * reach_px - row_px * row_px, 0.0)));
}

// Every pixel around: the background, with_background, and the foreground that is small, with discs
// up to foreground_px.
void gather_pixels(bool with_background, float foreground_px) {
    float slack_px = slack_of(own_px);
    float widest_px = max(with_background ? own_px + slack_px : 0.0, foreground_px);
    float reach_px = grid_radius_px(widest_px) + 0.5 * RIM_PX;
    int rows = int(reach_px * pixel_aspect);
    float per_margin = 1.0 / margin_px(p.a);
    vec4 over = vec4(0.0);
    for (int y = -rows; y <= rows; ++y) {
        float row_px = float(y) / pixel_aspect;
        int cells = cells_of(row_px, reach_px);
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texelFetch(colour_and_coc, clamp(pixel + ivec2(x, y), ivec2(0), last), 0);
            float away = sqrt(float(x * x) + row_px * row_px);
            float radius = abs(q.a);
            float as_own = clamp(radius, own_px - slack_px, own_px + slack_px);
#ifdef ONE_SURFACE
            background += disc_share(away, grid_radius_px(as_own)) * vec4(q.rgb, 1.0);
#else
            float is_foreground = clamp((p.a - q.a) * per_margin - 1.0, 0.0, 1.0);  // nearer()
            float share = disc_share(away, grid_radius_px(mix(as_own, radius, is_foreground)));
            background += (with_background ? (1.0 - is_foreground) * share : 0.0) * vec4(q.rgb, 1.0);
            over += (radius <= SMALL_PX ? is_foreground * share : 0.0) * vec4(q.rgb, 1.0);
#endif
        }
    }
    foreground += over / (PI * pixel_aspect);
}

#ifdef WIDE_LAYERS
#include "bilateral_upsample.glsl"

// Rings over a disc: the background within background_px, and the wide foreground.
void gather_rings(float disc_px, float background_px) {
    int rings = disc_px > 0.0 ? ring_count(disc_px, SPACING_PX) : 0;
    float spacing = disc_px / (float(rings) + 0.5);
    float area = 0.25 * PI * spacing * spacing;
    int i = 0;
    for (int ring = 1; ring <= rings; ++ring) {
        float away = ring_radius(ring, spacing);
        float own = disc_weight(away, background_px, spacing);
        for (int k = 0; k < 8 * ring; ++k, ++i) {
            vec2 at = vec2(pixel) + 0.5 + away * directions[i] * vec2(1.0, pixel_aspect);
            vec4 q = texelFetch(colour_and_coc, clamp(ivec2(floor(at)), ivec2(0), last), 0);
            float is_foreground = nearer(p.a, q.a);
            float radius = abs(q.a);
            background += (1.0 - is_foreground) * own * vec4(q.rgb, 1.0);
            foreground += (radius > SMALL_PX ? is_foreground : 0.0)
                   * foreground_opacity(away, radius, spacing, area) * vec4(q.rgb, 1.0);
        }
    }
}

// The wide discs, p's own and those of the foreground up to foreground_px: one walk, or two if
// these are wider.
void walk_rings(bool wide, float foreground_px) {
    background += wide ? vec4(p.rgb, 1.0) : vec4(0.0);
    bool together = foreground_px <= 1.25 * own_px;
    for (int walk = wide ? 0 : 1; walk < (together ? 1 : 2); ++walk)
        gather_rings(walk > 0 ? foreground_px : max(own_px, together ? foreground_px : 0.0),
                     walk > 0 ? -1e4 : own_px);
}

// What is wide, p's own disc (wide) and what is in front of it (has_wide_foreground).
void gather_wide(vec4 tile, bool wide, bool has_wide_foreground) {
    bool layered = wide || has_wide_foreground;
    float foreground_px = has_wide_foreground ? max(-tile.a, p.a) : 0.0;
    bool very_wide = own_px > COARSE_PX;
    float around = bilateral_upsample(pixel, p.a, layered, has_wide_foreground || very_wide, very_wide);
    if (around >= (very_wide ? BEHIND : foreground_px > COARSE_PX ? SOME_AROUND : ALL_AROUND)) {
        background += wide ? upsampled_background : vec4(0.0);
        foreground += upsampled_foreground;
        layered = false;
    }
    for (bool on = layered; on; on = false)
        walk_rings(wide, foreground_px);
}
#endif

// What reaches p from this tile's surroundings; false if nothing but p itself.
bool gather() {
    bool small = own_px > 0.5 && own_px <= SMALL_PX;
#ifdef ONE_SURFACE
    for (bool on = small; on; on = false)
        gather_pixels(true, 0.0);
#else
    vec4 tile = texelFetch(dilated, pixel / TILE, 0);
    float nearest = p.a - margin_px(p.a);  // what is less is a foreground
    bool small_foreground = tile.b > 0.0 && tile.r < nearest;
    background = own_px <= 0.5 ? vec4(p.rgb, 1.0) : vec4(0.0);
#ifdef WIDE_LAYERS
    gather_wide(tile, own_px > SMALL_PX, tile.a < nearest);
#endif
    for (bool on = small || small_foreground; on; on = false)
        gather_pixels(small, small_foreground ? min(tile.b, max(-tile.r, p.a)) : 0.0);
#endif
    return foreground.a > 0.0 || own_px > 0.5;
}

void main() {
    blurred = texelFetch(colour, pixel, 0);
    if (!gather())
        return;
    vec3 over = foreground.a > 0.0 ? foreground.rgb / foreground.a : vec3(0.0);
    blurred.rgb = min(mix(background.rgb / background.a, over, min(foreground.a, 1.0)), 65504.0);
}

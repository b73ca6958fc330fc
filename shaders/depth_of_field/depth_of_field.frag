#version 450 core
// Depth of field by gathering what other pixels would scatter here, with who hides whom.
//
// Input:  colour (for exact copies), points (colour and signed CoC radius), reach (what may reach
//         this tile; not with ONE_SURFACE), wide_back and wide_front (half resolution; only with
//         WIDE_LAYERS). Radii in pixels of image width, negative in front of the focus.
// Output: the blurred image, linear HDR, full resolution.
//
// A pixel p looks for two kinds of neighbours q, told apart by their CoC, which orders depth:
//
//   back   q is p's own surface or behind it. A lens sample u sees p's surface at p + u r_p, or
//          past its silhouette something behind: the average over p's OWN disc. Where q is p's
//          surface, q's own disc says how much of q lands here, so that lamps keep their light.
//   front  q is nearer than p. Its disc covers p if it is wide enough: q adds 1 / area(q) to an
//          opacity, and the front goes over the back. A sharp q covers no neighbour, so sharp
//          silhouettes do not bleed; a blurred near q spreads over a sharp p.
//
//        front disc of q          On one slanted surface both kinds give the same answer, so
//           ___                   where the line between them is drawn does not show.
//         /     \                 The back is normalised (a constant image stays constant), the
//     ---|---p---|--- back        front's opacity is absolute and stops at 1.
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
// kind of tile (include/kinds.glsl) has a program: ONE_SURFACE with small discs alone, several
// surfaces with small discs, and WIDE_LAYERS with everything.
#include "coc.glsl"
#include "gather.glsl"

uniform sampler2D colour;
uniform sampler2D points;
#ifndef ONE_SURFACE
uniform sampler2D reach;
#endif

out vec4 blurred;

// Taps of a ring pattern lie about this far apart (px) until RINGS is reached.
const float SPACING_PX = 1.25;

ivec2 pixel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(points, 0) - 1;
vec4 p = texelFetch(points, pixel, 0);
float own_px = abs(p.a);

vec4 back = vec4(0.0);   // rgb * weight, weight
vec4 front = vec4(0.0);  // rgb * opacity, opacity

// How many pixels to either side a row has within reach.
int cells_of(float row_px, float reach_px) {
    return int(sqrt(max(reach_px * reach_px - row_px * row_px, 0.0)));
}

// Every pixel around: the back, with_back, and the fronts that are small, with discs up to front_px.
void gather_pixels(bool with_back, float front_px) {
    float slack_px = slack_of(own_px);
    float widest_px = max(with_back ? own_px + slack_px : 0.0, front_px);
    float reach_px = grid_radius_px(widest_px) + 0.5 * RIM_PX;
    int rows = int(reach_px * pixel_aspect);
    float per_margin = 1.0 / margin_px(p.a);
    vec4 over = vec4(0.0);
    for (int y = -rows; y <= rows; ++y) {
        float row_px = float(y) / pixel_aspect;
        int cells = cells_of(row_px, reach_px);
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texelFetch(points, clamp(pixel + ivec2(x, y), ivec2(0), last), 0);
            float away = sqrt(float(x * x) + row_px * row_px);
            float radius = abs(q.a);
            float as_own = clamp(radius, own_px - slack_px, own_px + slack_px);
#ifdef ONE_SURFACE
            back += disc_share(away, grid_radius_px(as_own)) * vec4(q.rgb, 1.0);
#else
            float is_front = clamp((p.a - q.a) * per_margin - 1.0, 0.0, 1.0);  // nearer()
            float share = disc_share(away, grid_radius_px(mix(as_own, radius, is_front)));
            back += (with_back ? (1.0 - is_front) * share : 0.0) * vec4(q.rgb, 1.0);
            over += (radius <= SMALL_PX ? is_front * share : 0.0) * vec4(q.rgb, 1.0);
#endif
        }
    }
    front += over / (PI * pixel_aspect);
}

#ifdef WIDE_LAYERS
#include "wide_layers.glsl"

// Rings over a disc: the back within back_px, and wide fronts.
void gather_rings(float disc_px, float back_px) {
    int rings = disc_px > 0.0 ? ring_count(disc_px, SPACING_PX) : 0;
    float spacing = disc_px / (float(rings) + 0.5);
    float area = 0.25 * PI * spacing * spacing;
    int i = 0;
    for (int ring = 1; ring <= rings; ++ring) {
        float away = ring_radius(ring, spacing);
        float own = disc_weight(away, back_px, spacing);
        for (int k = 0; k < 8 * ring; ++k, ++i) {
            vec2 at = vec2(pixel) + 0.5 + away * directions[i] * vec2(1.0, pixel_aspect);
            vec4 q = texelFetch(points, clamp(ivec2(floor(at)), ivec2(0), last), 0);
            float is_front = nearer(p.a, q.a);
            float radius = abs(q.a);
            back += (1.0 - is_front) * own * vec4(q.rgb, 1.0);
            front += (radius > SMALL_PX ? is_front : 0.0)
                   * front_opacity(away, radius, spacing, area) * vec4(q.rgb, 1.0);
        }
    }
}

// The wide discs, p's own and those of fronts up to front_px: one walk, or two if these are wider.
void walk_rings(bool wide, float front_px) {
    back += wide ? vec4(p.rgb, 1.0) : vec4(0.0);
    bool together = front_px <= 1.25 * own_px;
    for (int walk = wide ? 0 : 1; walk < (together ? 1 : 2); ++walk)
        gather_rings(walk > 0 ? front_px : max(own_px, together ? front_px : 0.0),
                     walk > 0 ? -1e4 : own_px);
}

// What is wide, p's own disc (wide) and what is in front of it (wide_front_).
void gather_wide(vec4 tile, bool wide, bool wide_front_) {
    bool layered = wide || wide_front_;
    float front_px = wide_front_ ? max(-tile.a, p.a) : 0.0;
    bool very_wide = own_px > FAR_PX;
    float around = mix_layers(pixel, p.a, layered, wide_front_ || very_wide, very_wide);
    if (around >= (very_wide ? BEHIND : front_px > FAR_PX ? SOME_AROUND : ALL_AROUND)) {
        back += wide ? mixed_back : vec4(0.0);
        front += mixed_front;
        layered = false;
    }
    for (bool on = layered; on; on = false)
        walk_rings(wide, front_px);
}
#endif

// What reaches p from this tile's surroundings; false if nothing but p itself.
bool gather() {
    bool small = own_px > 0.5 && own_px <= SMALL_PX;
#ifdef ONE_SURFACE
    for (bool on = small; on; on = false)
        gather_pixels(true, 0.0);
#else
    vec4 tile = texelFetch(reach, pixel / TILE, 0);
    float nearest = p.a - margin_px(p.a);  // what is less is a front
    bool small_front = tile.b > 0.0 && tile.r < nearest;
    back = own_px <= 0.5 ? vec4(p.rgb, 1.0) : vec4(0.0);
#ifdef WIDE_LAYERS
    gather_wide(tile, own_px > SMALL_PX, tile.a < nearest);
#endif
    for (bool on = small || small_front; on; on = false)
        gather_pixels(small, small_front ? min(tile.b, max(-tile.r, p.a)) : 0.0);
#endif
    return front.a > 0.0 || own_px > 0.5;
}

void main() {
    blurred = texelFetch(colour, pixel, 0);
    if (!gather())
        return;
    vec3 over = front.a > 0.0 ? front.rgb / front.a : vec3(0.0);
    blurred.rgb = min(mix(back.rgb / back.a, over, min(front.a, 1.0)), 65504.0);
}

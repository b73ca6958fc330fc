#version 450 core
// Depth of field by gathering what other pixels would scatter here, with who hides whom.
//
// Input:  colour (for exact copies), points (colour and signed CoC radius), wide_back and wide_front
//         (half resolution), reach (what may reach this tile). Radii in pixels of image width,
//         negative in front of the focus.
// Output: the blurred image, linear HDR, full resolution.
//
// A pixel p looks for two kinds of neighbours q, told apart by their CoC, which orders depth:
//
//   back   q is p's own surface or behind it. A lens sample u sees p's surface at p + u r_p, or
//          past its silhouette something behind: the average over p's OWN disc.
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
// Discs up to SMALL_PX are summed over every pixel. Wider ones come from half resolution where
// the texels around are on p's surface; elsewhere (thin things, rims) p walks its own rings. No noise, hence the same kernel in both eyes. Carnegie & Rhee 2015,
// Algorithm 1; gathering after Jimenez 2014, "Next generation post processing in Call of Duty:
// Advanced Warfare".
#include "coc.glsl"
#include "gather.glsl"

uniform sampler2D colour;
uniform sampler2D points;
uniform sampler2D wide_back;
uniform sampler2D wide_front;
uniform sampler2D reach;

out vec4 blurred;

// Taps of a ring pattern lie about this far apart (px) until RINGS is reached.
const float SPACING_PX = 1.25;

ivec2 pixel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(points, 0) - 1;
vec4 p = texelFetch(points, pixel, 0);
float own_px = abs(p.a);

vec4 back = vec4(0.0);   // rgb * weight, weight
vec4 front = vec4(0.0);  // rgb * opacity, opacity

// Every pixel nearer than reach_px: the back if p is small itself, and small fronts.
void gather_dense(float reach_px, bool with_back) {
    int cells = int(ceil(reach_px)) - 1;
    int rows = int(ceil(reach_px * pixel_aspect)) - 1;
    float disc_px = grid_radius_px(own_px);
    for (int y = -rows; y <= rows; ++y)
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texelFetch(points, clamp(pixel + ivec2(x, y), ivec2(0), last), 0);
            float away = length(vec2(x, float(y) / pixel_aspect));
            float is_front = nearer(p.a, q.a);
            if (with_back)
                back += (1.0 - is_front) * disc_weight(away, disc_px, 1.0) * vec4(q.rgb, 1.0);
            float radius = abs(q.a);
            if (is_front > 0.0 && radius > 0.5 && radius <= SMALL_PX)
                front += is_front * front_opacity(away, grid_radius_px(radius), 1.0, 1.0 / pixel_aspect)
                       * vec4(q.rgb, 1.0);
        }
}

// Rings over a disc: the back within p's own disc, and wide fronts.
void gather_rings(float disc_px, float back_px) {
    int rings = ring_count(disc_px, SPACING_PX);
    float spacing = disc_px / (float(rings) + 0.5);
    float area = 0.25 * PI * spacing * spacing;
    int i = 0;
    for (int ring = 1; ring <= rings; ++ring) {
        float away = ring_radius(ring, spacing);
        for (int k = 0; k < 8 * ring; ++k, ++i) {
            vec2 at = vec2(pixel) + 0.5 + away * directions[i] * vec2(1.0, pixel_aspect);
            vec4 q = texelFetch(points, clamp(ivec2(floor(at)), ivec2(0), last), 0);
            float is_front = nearer(p.a, q.a);
            back += (1.0 - is_front) * disc_weight(away, back_px, spacing) * vec4(q.rgb, 1.0);
            if (is_front > 0.0 && abs(q.a) > SMALL_PX)
                front += is_front * front_opacity(away, abs(q.a), spacing, area) * vec4(q.rgb, 1.0);
        }
    }
}

// The wide layers, mixed from the texels around; false unless these are on p's surface.
bool mix_halves(bool with_back, bool with_front) {
    ivec2 first = pixel / 2;
    ivec2 last_half = textureSize(wide_back, 0) - 1;
    float tolerance = 1.0 / (2.0 * margin_px(p.a));
    vec4 backs = vec4(0.0), fronts = vec4(0.0);
    ivec2 odd = pixel & 1;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = min(first + (ivec2(i, i >> 1) & odd), last_half);
        vec4 b = texelFetch(wide_back, texel, 0);
        float like = clamp(2.0 - abs(b.a - p.a) * tolerance, 0.0, 1.0);
        backs += like * vec4(b.rgb, 1.0);
        if (with_front)
            fronts += like * texelFetch(wide_front, texel, 0);
    }
    if (backs.a < 3.5)  // beside a rim the texels of one side would draw a line along it
        return false;
    back += with_back ? vec4(backs.rgb / backs.a, 1.0) : vec4(0.0);
    front += fronts / backs.a;
    return true;
}

// What reaches p from this tile's surroundings.
void blur(vec4 tile, bool small_front, bool wide_front_) {
    bool wide = own_px > SMALL_PX;
    bool halves = wide ? own_px > (is_alike(p.a, tile) ? ALIKE_PX : MIXED_PX) : -tile.a > MIXED_PX;
    if ((wide || wide_front_) && !(halves && mix_halves(wide, wide_front_))) {
        float reach_px = wide_front_ ? max(-tile.a, p.a) : 0.0;
        bool one_walk = reach_px <= 1.25 * own_px;
        back += wide ? vec4(p.rgb, 1.0) : vec4(0.0);
        if (wide)
            gather_rings(one_walk ? max(own_px, reach_px) : own_px, own_px);
        if (!one_walk)
            gather_rings(reach_px, -reach_px);
    }
    if (!wide || small_front) {
        float widest_px = max(wide ? 0.0 : own_px, small_front ? tile.b : 0.0);
        gather_dense(0.5 + (widest_px <= 1.5 ? 1.5 : SMALL_PX), !wide);
    }
    if (front.a <= 0.0 && own_px <= 0.5)
        return;
    vec3 over = front.a > 0.0 ? front.rgb / front.a : vec3(0.0);
    blurred.rgb = min(mix(back.rgb / back.a, over, min(front.a, 1.0)), 65504.0);
}

void main() {
    vec4 tile = texelFetch(reach, pixel / TILE, 0);
    blurred = texelFetch(colour, pixel, 0);
    float nearest = p.a - margin_px(p.a);  // what is less is a front
    bool small_front = tile.b > 0.0 && tile.r < nearest;
    bool wide_front_ = tile.a < nearest;
    if (own_px > 0.5 || small_front || wide_front_)
        blur(tile, small_front, wide_front_);
}

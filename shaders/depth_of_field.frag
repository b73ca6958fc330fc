#version 450 core
// Depth of field by gathering what other pixels would scatter here, with who hides whom.
//
// Input:  colour (for exact copies), points (colour and signed CoC radius), points_half, reach
//         (what may reach this tile). Radii in pixels of image width, negative in front of focus.
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
// Wide discs are sampled on rings (RINGS at most), small ones on every pixel: no noise, hence the
// same kernel in both eyes. Carnegie & Rhee 2015, Algorithm 1; gathering after Jimenez 2014,
// "Next generation post processing in Call of Duty: Advanced Warfare".
#include "coc.glsl"

uniform sampler2D colour;
uniform sampler2D points;
uniform sampler2D points_half;
uniform sampler2D reach;
uniform vec2 directions[4 * RINGS * (RINGS + 1)];  // optics.circle_of_confusion.ring_directions
uniform float pixel_aspect;                        // image pixels per unit, vertical / horizontal

out vec4 blurred;

// Taps of a ring pattern lie about this far apart (px) until RINGS is reached.
const float SPACING_PX = 1.25;
// Beyond this spacing (px) taps read the half-resolution image.
const float HALF_SPACING_PX = 1.6;

ivec2 pixel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(points, 0) - 1;
vec4 p = texelFetch(points, pixel, 0);
float own_px = abs(p.a);

vec4 back = vec4(0.0);   // rgb * weight, weight
vec4 front = vec4(0.0);  // rgb * opacity, opacity

// 0 where q is p's surface or behind it, 1 where it is nearer. An eighth of a pixel is well above
// the rounding of half floats and well below what a blur shows.
float nearer(vec4 q) {
    return clamp((p.a - q.a) * 8.0 - 1.0, 0.0, 1.0);
}

// A tap at some distance that stands for `area` square pixels; fronts with radii in (from, to].
void add(vec4 q, float distance_px, float softness, float area, float back_px, vec2 front_px) {
    float is_front = nearer(q);
    float radius = abs(q.a);
    float in_back = (1.0 - is_front) * disc_weight(distance_px, back_px, softness);
    back += in_back * vec4(q.rgb, 1.0);
    bool counts = radius > front_px.x && radius <= front_px.y;
    float over = counts ? is_front * disc_weight(distance_px, radius, softness) : 0.0;
    front += over * area / disc_area_px(radius, softness) * vec4(q.rgb, 1.0);
}

// Every pixel within `cells`: the back if it is small (back_px > 0), and small fronts.
void gather_dense(int cells, float back_px, vec2 front_px) {
    int rows = int(ceil((float(cells) + 0.5) * pixel_aspect)) - 1;
    for (int y = -rows; y <= rows; ++y)
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texelFetch(points, clamp(pixel + ivec2(x, y), ivec2(0), last), 0);
            add(q, length(vec2(x, float(y) / pixel_aspect)), 1.0, 1.0 / pixel_aspect, back_px, front_px);
        }
}

// Rings over a disc of radius disc_px: 8 taps on the first, 16 on the second, ...
void gather_rings(float disc_px, float back_px, vec2 front_px) {
    int rings = clamp(int(ceil(disc_px / SPACING_PX - 0.5)), 1, RINGS);
    float spacing = disc_px / (float(rings) + 0.5);
    float area = 0.25 * PI * spacing * spacing;
    bool halved = spacing > HALF_SPACING_PX;
    vec2 centre = vec2(pixel) + 0.5;
    int i = 0;
    for (int ring = 1; ring <= rings; ++ring)
        for (int tap = 0; tap < 8 * ring; ++tap, ++i) {
            // Not in the middle of its annulus but where its mean square distance is.
            float away = spacing * sqrt(float(ring * ring) + 0.25);
            vec2 at = centre + away * directions[i] * vec2(1.0, pixel_aspect);
            ivec2 texel = clamp(ivec2(floor(at)), ivec2(0), last);
            vec4 q = halved ? texelFetch(points_half, texel / 2, 0) : texelFetch(points, texel, 0);
            add(q, away, spacing, area, back_px, front_px);
        }
}

void main() {
    vec4 tile = texelFetch(reach, pixel / TILE, 0);
    float near_px = max(-tile.r, 0.0);  // the widest disc in front of the focus
    blurred = texelFetch(colour, pixel, 0);
    if (own_px <= 0.5 && near_px <= 0.5)
        return;
    const vec2 NONE = vec2(0.0);
    float wide_px = max(own_px, SMALL_PX);
    bool some_front = tile.r < p.a;
    if (own_px <= SMALL_PX || (some_front && tile.b > 0.0)) {
        bool back_here = own_px <= SMALL_PX;
        gather_dense(int(SMALL_PX), back_here ? own_px : -1.0, vec2(0.5, SMALL_PX));
    }
    if (own_px > SMALL_PX) {
        back += vec4(p.rgb, 1.0);
        gather_rings(own_px, own_px, vec2(SMALL_PX, own_px));
    }
    if (near_px > wide_px && some_front)
        gather_rings(near_px, -near_px, vec2(wide_px, near_px));
    if (front.a <= 0.0 && own_px <= 0.5)
        return;
    vec3 over = front.a > 0.0 ? front.rgb / front.a : vec3(0.0);
    blurred.rgb = min(mix(back.rgb / back.a, over, min(front.a, 1.0)), 65504.0);
}

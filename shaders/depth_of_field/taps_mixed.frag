#version 450 core
// Where surfaces mix: a few taps over a disc, told apart by their radii.
//
// Input:  points (colour and signed CoC RADIUS, px of image width, negative in front of the focus),
//         reach (tap_reach.frag). READ_HALVES: also halves (defocus_halve.frag) where taps are far apart.
//         offsets: TAPS points of the unit disc, evenly spread, the same in every pixel and eye.
// Output: the blurred image, linear HDR.
//
// The layers are those of depth_of_field.frag: a back that is normalised, over the pixel's own disc,
// and a front whose discs add opacity; a sharp front does not leak. Jimenez 2014, "Next generation
// post processing in Call of Duty: Advanced Warfare" (layers); Vogel 1979 (pattern).
#include "coc.glsl"

uniform sampler2D points;
#ifdef READ_HALVES
uniform sampler2D halves;
#endif
uniform sampler2D reach;
uniform vec2 offsets[TAPS];
uniform int tap_count;       // TAPS, which compilers must not know: unrolled loops do not end early
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

// Taps of a disc of radius 1 lie about this far apart.
const float SPACING = sqrt(PI / float(TAPS));

vec4 p;
vec4 back = vec4(0.0);   // rgb * weight, weight
vec4 front = vec4(0.0);  // rgb * opacity, opacity

// Taps over the pixel's own disc and over those of fronts: the same ones, or where fronts are much
// wider (apart) every second one each. No taps where they are not wanted: loops end early where
// branches do not.
void walk(sampler2D level, float texel_px, bool wanted, vec2 discs_px, bool apart) {
    int taps = wanted ? tap_count : 0;
    ivec2 last = textureSize(level, 0) - 1;
    float share = apart ? 2.0 : 1.0;
    vec2 spacings = max(SPACING * sqrt(share) * discs_px, 1.0);
    float area = share * PI * discs_px.y * discs_px.y / float(TAPS);
    for (int i = 0; i < taps; ++i) {
        bool own = !apart || (i & 1) == 1;
        vec2 away = (own ? discs_px.x : discs_px.y) * offsets[i];
        vec2 at = (gl_FragCoord.xy + away * vec2(1.0, pixel_aspect)) / texel_px;
        vec4 q = texelFetch(level, clamp(ivec2(floor(at)), ivec2(0), last), 0);
        float distance_px = length(away);
        float is_front = nearer(p.a, q.a);
        if (own)
            back += (1.0 - is_front) * disc_weight(distance_px, abs(p.a), spacings.x) * vec4(q.rgb, 1.0);
        float radius = abs(q.a);
        if (is_front > 0.0 && radius > 0.5 && !(apart && own))
            front += is_front * disc_weight(distance_px, radius, spacings.y) * area
                   / disc_area_px(radius, spacings.y) * vec4(q.rgb, 1.0);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    p = texelFetch(points, pixel, 0);
    vec4 tile = texelFetch(reach, pixel / TILE, 0);
    float own_px = abs(p.a);
    float front_px = tile.r < p.a - margin_px(p.a) ? -tile.r : 0.0;
    bool apart = front_px > 1.25 * own_px && own_px > 0.5;
    float widest_px = max(own_px, front_px);
    vec2 discs_px = vec2(apart ? own_px : widest_px, widest_px);
    back = vec4(p.rgb, own_px > 0.5 ? 0.05 : 1.0);
    back.rgb *= back.a;
#ifdef READ_HALVES
    bool far = SPACING * widest_px > FAR_PX;
    walk(points, 1.0, widest_px > 0.5 && !far, discs_px, apart);
    walk(halves, 2.0, far, discs_px, apart);
#else
    walk(points, 1.0, widest_px > 0.5, discs_px, apart);
#endif
    vec3 over = front.a > 0.0 ? front.rgb / front.a : vec3(0.0);
    blurred = vec4(min(mix(back.rgb / back.a, over, min(front.a, 1.0)), 65504.0), 1.0);
    if (own_px <= 0.5 && front.a <= 0.0)
        blurred.rgb = p.rgb;
}

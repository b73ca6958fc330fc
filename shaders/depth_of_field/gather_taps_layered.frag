#version 450 core
// Where surfaces mix: a few taps over a disc, told apart by their radii.
//
// Input:  colour_and_coc (colour and signed CoC RADIUS, px of image width, negative in front of the focus),
//         dilated (classify_tap_tiles.frag). READ_HALF_RESOLUTION: also half_resolution
//         (coc_downsample_box.frag) where taps are far apart.
//         offsets: TAPS points of the unit disc, evenly spread, the same in every pixel and eye.
// Output: the blurred image, linear HDR.
//
// The layers are those of gather_composite.frag: a back that is normalised, over the pixel's own disc,
// and a foreground whose discs add opacity; a sharp front does not leak. Jimenez 2014, "Next generation
// post processing in Call of Duty: Advanced Warfare" (layers); Vogel 1979 (pattern).
#include "coc.glsl"

uniform sampler2D colour_and_coc;
#ifdef READ_HALF_RESOLUTION
uniform sampler2D half_resolution;
#endif
uniform sampler2D dilated;
uniform vec2 offsets[TAPS];
uniform int tap_count;       // TAPS, which compilers must not know: unrolled loops do not end early
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

// Taps of a disc of radius 1 lie about this far apart.
const float SPACING = sqrt(PI / float(TAPS));

vec4 p;
vec4 background = vec4(0.0);   // rgb * weight, weight
vec4 foreground = vec4(0.0);  // rgb * opacity, opacity

// Taps over the pixel's own disc and over those of the foreground: the same ones, or where fronts are much
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
        float is_foreground = nearer(p.a, q.a);
        if (own)
            background += (1.0 - is_foreground) * disc_weight(distance_px, abs(p.a), spacings.x)
                        * vec4(q.rgb, 1.0);
        float radius = abs(q.a);
        if (is_foreground > 0.0 && radius > 0.5 && !(apart && own))
            foreground += is_foreground * disc_weight(distance_px, radius, spacings.y) * area
                   / disc_area_px(radius, spacings.y) * vec4(q.rgb, 1.0);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    p = texelFetch(colour_and_coc, pixel, 0);
    vec4 tile = texelFetch(dilated, pixel / TILE, 0);
    float own_px = abs(p.a);
    float foreground_px = tile.r < p.a - margin_px(p.a) ? -tile.r : 0.0;
    bool apart = foreground_px > 1.25 * own_px && own_px > 0.5;
    float widest_px = max(own_px, foreground_px);
    vec2 discs_px = vec2(apart ? own_px : widest_px, widest_px);
    background = vec4(p.rgb, own_px > 0.5 ? 0.05 : 1.0);
    background.rgb *= background.a;
#ifdef READ_HALF_RESOLUTION
    bool sparse = SPACING * widest_px > SPARSE_PX;
    walk(colour_and_coc, 1.0, widest_px > 0.5 && !sparse, discs_px, apart);
    walk(half_resolution, 2.0, sparse, discs_px, apart);
#else
    walk(colour_and_coc, 1.0, widest_px > 0.5, discs_px, apart);
#endif
    vec3 over = foreground.a > 0.0 ? foreground.rgb / foreground.a : vec3(0.0);
    blurred = vec4(min(mix(background.rgb / background.a, over, min(foreground.a, 1.0)), 65504.0), 1.0);
    if (own_px <= 0.5 && foreground.a <= 0.0)
        blurred.rgb = p.rgb;
}

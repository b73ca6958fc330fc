#version 450 core
// Where surfaces mix: a few taps over a disc, told apart by their radii.
//
// Input:  colour (for exact copies), points (colour and signed CoC RADIUS, px of image width,
//         negative in front of the focus), halves (defocus_halve.frag), reach (defocus_reach.frag).
//         offsets: TAPS points of the unit disc, evenly spread, the same in every pixel and eye.
// Output: the blurred image, linear HDR.
//
// The layers are those of depth_of_field.frag: a back that is normalised, over the pixel's own disc,
// and a front whose discs add opacity. Colours are read bilinearly where the four texels around are
// of one surface; a sharp front does not leak. Jimenez 2014, "Next generation post processing in
// Call of Duty: Advanced Warfare" (layers); Vogel 1979 (pattern).
#include "coc.glsl"

uniform sampler2D colour;
uniform sampler2D points;
uniform sampler2D halves;
uniform sampler2D reach;
uniform vec2 offsets[TAPS];
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

// Taps of a disc of radius 1 lie about this far apart.
const float SPACING = sqrt(PI / float(TAPS));
// Radii that differ by less (px) around a tap are of one surface.
const float FLAT_PX = 0.03;

vec4 p;
vec4 back = vec4(0.0);   // rgb * weight, weight
vec4 front = vec4(0.0);  // rgb * opacity, opacity

float margin_px(float radius) {
    return max(0.125, 0.05 * abs(radius));
}

// Taps over a disc: the back within back_px, and fronts. No taps where it is not wanted: loops end
// early where branches do not.
void walk(sampler2D level, float texel, bool wanted, float disc_px, float back_px) {
    int taps = wanted ? TAPS : 0;
    ivec2 last = textureSize(level, 0) - 1;
    vec2 size = vec2(last + 1);
    float spacing = max(SPACING * disc_px, 1.0);
    float area = PI * disc_px * disc_px / float(TAPS);
    for (int i = 0; i < taps; ++i) {
        vec2 away = disc_px * offsets[i];
        vec2 at = (gl_FragCoord.xy + away * vec2(1.0, pixel_aspect)) / texel;
        vec4 q = texelFetch(level, clamp(ivec2(floor(at)), ivec2(0), last), 0);
        vec4 mixed = textureLod(level, at / size, 0.0);
        q.rgb = mix(mixed.rgb, q.rgb, clamp(abs(mixed.a - q.a) / FLAT_PX - 1.0, 0.0, 1.0));
        float distance_px = length(away);
        float is_front = clamp((p.a - q.a) / margin_px(p.a) - 1.0, 0.0, 1.0);
        back += (1.0 - is_front) * disc_weight(distance_px, back_px, spacing) * vec4(q.rgb, 1.0);
        float radius = abs(q.a);
        if (is_front > 0.0 && radius > 0.5)
            front += is_front * disc_weight(distance_px, radius, spacing) * area
                   / disc_area_px(radius, spacing) * vec4(q.rgb, 1.0);
    }
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    p = texelFetch(points, pixel, 0);
    vec4 tile = texelFetch(reach, pixel / TILE, 0);
    float own_px = abs(p.a);
    float front_px = tile.r < p.a - margin_px(p.a) ? -tile.r : 0.0;
    bool one_walk = front_px <= 1.25 * own_px;
    float disc_px = one_walk ? max(own_px, front_px) : own_px;
    bool fine = SPACING * disc_px <= 2.0;
    bool fine_front = SPACING * front_px <= 2.0;
    bool apart = !one_walk && front_px > 0.5;
    back = vec4(p.rgb, own_px > 0.5 ? 0.05 : 1.0);
    back.rgb *= back.a;
    walk(points, 1.0, own_px > 0.5 && fine, disc_px, own_px);
    walk(halves, 2.0, own_px > 0.5 && !fine, disc_px, own_px);
    walk(points, 1.0, apart && fine_front, front_px, -1e4);
    walk(halves, 2.0, apart && !fine_front, front_px, -1e4);
    vec3 over = front.a > 0.0 ? front.rgb / front.a : vec3(0.0);
    blurred = vec4(min(mix(back.rgb / back.a, over, min(front.a, 1.0)), 65504.0), 1.0);
    if (own_px <= 0.5 && front.a <= 0.0)
        blurred = texelFetch(colour, pixel, 0);
}

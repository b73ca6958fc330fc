#version 450 core
// A disc of one width for all pixels, gathered at half resolution: samples count where blur reaches.
//
// Input:  half_image of half_resolution.frag (signed CoC RADIUS, px of the whole image, negative in
//         front of the focus), read bilinearly; widest: 1x1, largest radius in the image, px.
// Output: rgb times opacity, and opacity: background under foreground.
//
//         reach
//    |<------------>|      every pixel looks as far as the widest disc in the image, however small
//    .  .  .  o  .  .  .   its own: a sample counts up to the smaller of both radii (behind), or up
//       |<-- a -->|        to its own (in front)
//
// NumPy twin: tests/oracles/half_resolution.py. As the bokeh filter of KinoBokeh (Takahashi, for
// Unity), 43 samples.
#include "eyes.glsl"
uniform eye_image half_image;
#ifdef WIDEST
uniform eye_image widest;
#endif
uniform vec2 offsets[TAPS];   // in the unit disc
uniform float pixel_aspect_of_eye[EYES];   // image pixels per unit, vertical / horizontal
float pixel_aspect = pixel_aspect_of_eye[EYE];
uniform float max_radius_px;

out vec4 blurred;

const float TEXEL_PX = 2.0;
const float MARGIN_PX = 2.0 * TEXEL_PX;
const float PI = 3.14159265;

void main() {
    vec2 size_px = 2.0 * vec2(size_of(half_image));
    vec4 centre = texel_of(half_image, ivec2(gl_FragCoord.xy));
    float reach_px = max_radius_px;
#ifdef WIDEST
    reach_px = min(reach_px, texel_of(widest, ivec2(0)).r);
#endif
    vec4 behind = vec4(0.0), front = vec4(0.0);
    for (int i = 0; i < TAPS; ++i) {
        vec2 away_px = reach_px * offsets[i];
        float distance_px = length(away_px);
        vec2 place = (2.0 * gl_FragCoord.xy + away_px * vec2(1.0, pixel_aspect)) / size_px;
        vec4 tap = filtered_at(half_image, place);
        float far_px = max(min(centre.a, tap.a), 0.0);
        float far = clamp((far_px - distance_px + MARGIN_PX) / MARGIN_PX, 0.0, 1.0);
        float near = clamp((-tap.a - distance_px + MARGIN_PX) / MARGIN_PX, 0.0, 1.0);
        behind += far * vec4(tap.rgb, 1.0);
        front += near * step(TEXEL_PX, -tap.a) * vec4(tap.rgb, 1.0);
    }
    vec3 back = behind.a > 0.0 ? behind.rgb / behind.a : centre.rgb;
    vec3 fore = front.a > 0.0 ? front.rgb / front.a : back;
    float back_opacity = smoothstep(TEXEL_PX, 2.0 * TEXEL_PX, centre.a);
    float opacity = clamp(front.a * PI / float(TAPS), 0.0, 1.0);
    vec3 colour = mix(back_opacity * back, fore, opacity);
    blurred = vec4(min(colour, HALF_MAX), 1.0 - (1.0 - back_opacity) * (1.0 - opacity));
}

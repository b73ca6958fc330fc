#version 450 core
// Fifteen taps in a circle of confusion that a blurred foreground widens beyond its own silhouette edge.
//
// Input:  colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width, negative in
//         front of the
//         focus), near_mean of poisson15_near_mean.frag. Colours and means are read bilinearly.
// Output: the blurred image, linear HDR, full resolution.
//
//   own  ___          mean ..__          2 max(own, mean) - own ___
//           |                  ''..                                ''..
//           |___                   ''..                                ''.   joins at the outline
//
// The far circle is as it is; the wider of the two counts. Every tap weighs the same: a sharp foreground
// leaks, and a background beside a blurred foreground is blurred with it (the paper says so of both).
// NumPy twin: tests/oracles/poisson_taps.py. Mantiuk et al. 2011, Eq. 2 and section 4.
#include "eyes.glsl"
uniform eye_image colour_and_coc;
uniform eye_image near_mean;
uniform vec2 offsets[TAPS];   // in a disc of radius 0.5
uniform float pixel_aspect_of_eye[EYES];   // image pixels per unit, vertical / horizontal
float pixel_aspect = pixel_aspect_of_eye[EYE];
uniform float max_radius_px;

out vec4 blurred;

float blur_radius_px(float signed_px) {
    float own = max(-signed_px, 0.0);
    vec2 cells = vec2(size_of(near_mean));
    float mean = filtered_at(near_mean, gl_FragCoord.xy / float(CELL) / cells).r;
    return min(max(2.0 * max(own, mean) - own, signed_px), max_radius_px);
}

void main() {
    vec2 size_px = vec2(size_of(colour_and_coc));
    vec4 p = texel_of(colour_and_coc, ivec2(gl_FragCoord.xy));
    float radius_px = blur_radius_px(p.a);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < TAPS; ++i) {
        vec2 away_px = 2.0 * radius_px * offsets[i] * vec2(1.0, pixel_aspect);
        sum += filtered_at(colour_and_coc, (gl_FragCoord.xy + away_px) / size_px).rgb;
    }
    // Fifteen times the same over fifteen may be off by one bit.
    blurred = vec4(radius_px > 0.0 ? min(sum / float(TAPS), HALF_MAX) : p.rgb, 1.0);
}

#version 450 core
// Twelve taps in a pixel's own circle of confusion, turned by an angle of its own.
//
// Input:  colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width, negative in
//         front of the
//         focus; colours are read bilinearly, radii from the nearest pixel), rotations (cos A, sin
//         A; repeated over the image).
// Output: the blurred image, linear HDR, full resolution.
//
// The paper's cocSize is a DIAMETER: its offsets lie in a disc of radius 0.5. Its circles are
// normalised by the largest one. Depth is compared through the signed radius, which orders depth;
// where two radii are clamped alike both branches weigh 1.
// NumPy twin: tests/oracles/poisson_taps.py. Hillaire et al. 2008, Fig. 3, with the sample's colour
// (the print has its circle of confusion) in the sum.
#include "eyes.glsl"
uniform eye_image colour_and_coc;
uniform sampler2D rotations;
uniform vec2 offsets[TAPS];
uniform float pixel_aspect_of_eye[EYES];   // image pixels per unit, vertical / horizontal
float pixel_aspect = pixel_aspect_of_eye[EYE];
uniform float max_radius_px;

out vec4 blurred;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 last = size_of(colour_and_coc) - 1;
    vec4 p = texel_of(colour_and_coc, pixel);
    vec2 turn = texelFetch(rotations, pixel % textureSize(rotations, 0), 0).xy;
    mat2 turned_from_offset = mat2(turn.x, turn.y, -turn.y, turn.x);
    float diameter_px = 2.0 * abs(p.a);
    vec4 sum = vec4(p.rgb, 1.0);
    for (int i = 0; i < TAPS; ++i) {
        vec2 away_px = diameter_px * (turned_from_offset * offsets[i]) * vec2(1.0, pixel_aspect);
        vec2 tap = gl_FragCoord.xy + away_px;
        float q = texel_of(colour_and_coc, clamp(ivec2(floor(tap)), ivec2(0), last)).a;
        // What is nearer counts as far as it is blurred: a sharp foreground does not leak.
        float weight = q > p.a ? 1.0 : min(abs(q) / max(max_radius_px, 1e-6), 1.0);
        sum += weight * vec4(filtered_at(colour_and_coc, tap / vec2(last + 1)).rgb, 1.0);
    }
    blurred = vec4(min(sum.rgb / sum.a, HALF_MAX), 1.0);
}

#version 450 core
// One axis of a Gaussian blur; two make a round one.
//
// Input:  image (linear HDR). sigma_px is the standard deviation along this axis, in px, above 0.
// Output: the image blurred along AXIS (0: x, 1: y); beyond the image its border goes on.
// NumPy twin: tests/oracles/gaussian.py.
#include "eyes.glsl"
uniform eye_image image;
uniform float sigma_px_of_eye[EYES];
float sigma_px = sigma_px_of_eye[EYE];

out vec4 blurred;

const float REACH = 3.0;  // standard deviations

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 last = size_of(image) - 1;
    ivec2 step_px = AXIS == 0 ? ivec2(1, 0) : ivec2(0, 1);
    int reach = int(ceil(REACH * sigma_px));
    float falloff = -0.5 / (sigma_px * sigma_px);
    vec4 sum = vec4(texel_of(image, pixel).rgb, 1.0);
    for (int i = 1; i <= reach; ++i) {
        vec3 a = texel_of(image, max(pixel - i * step_px, ivec2(0))).rgb;
        vec3 b = texel_of(image, min(pixel + i * step_px, last)).rgb;
        sum += exp(falloff * float(i * i)) * vec4(a + b, 2.0);
    }
    blurred = vec4(min(sum.rgb / sum.a, HALF_MAX), 1.0);
}

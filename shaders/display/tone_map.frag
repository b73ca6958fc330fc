#version 450 core
// Linear HDR radiance to what a display gets: exposure, Khronos PBR neutral, sRGB, dither.
//
// Input:  linear radiance, exposure factor, blue_noise: thresholds between 0 and 1.
// Output: sRGB-encoded colour in [0, 1], alpha 1, less than a step of 8 bits off: rounded, its mean
//         over some pixels is that of the light. What 8 bits can hold (black, white) is unchanged.
// Twins:  vrcomfort/optics/tone.py, where the curve is explained; vrcomfort/optics/dither.py.
#include "eyes.glsl"
#include "tone.glsl"

layout(binding = 0) uniform eye_image radiance;
layout(binding = 1) uniform sampler2D blue_noise;
uniform float exposure;
out vec4 encoded;

void main() {
    vec3 color = texel_of(radiance, ivec2(gl_FragCoord.xy)).rgb;
    ivec2 noise_at = ivec2(gl_FragCoord.xy) % textureSize(blue_noise, 0);
    float offset = (texelFetch(blue_noise, noise_at, 0).r - 0.5) / 255.0;
    color = srgb_encoded(pbr_neutral(exposure * color));
    encoded = vec4(clamp(color + offset, 0.0, 1.0), 1.0);
}

#version 450 core
// Linear HDR radiance to what a display gets: exposure, Khronos PBR neutral, sRGB.
//
// Input:  linear radiance, exposure factor.
// Output: sRGB-encoded colour in [0, 1], alpha 1.
// Twin:   vrcomfort/optics/tone.py, where the curve is explained.
#include "tone.glsl"

layout(binding = 0) uniform sampler2D radiance;
uniform float exposure;
out vec4 encoded;

void main() {
    vec3 color = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb;
    encoded = vec4(srgb_encoded(pbr_neutral(exposure * color)), 1.0);
}

#version 450 core
// Copies an image times a number: adds up views of a lens (blended), and divides the sum.
//
// Input:  image (linear HDR), share (1 to add, 1 / views to divide).
// Output: rgb times share, within half floats; alpha 1.
#include "finite.glsl"

layout(binding = 0) uniform sampler2D image;

uniform float share;

out vec4 scaled;

void main() {
    vec3 c = texelFetch(image, ivec2(gl_FragCoord.xy), 0).rgb * share;
    scaled = vec4(min(c, HALF_MAX), 1.0);
}

#version 450 core
// Copies an image times a number: adds up views of a lens (blended), and divides the sum.
//
// Input:  image (linear HDR), share (1 to add, 1 / views to divide).
// Output: rgb times share, within half floats; alpha 1.
#include "eyes.glsl"
#include "finite.glsl"

layout(binding = 0) uniform eye_image image;

uniform float share;

out vec4 scaled;

void main() {
    vec3 c = texel_of(image, ivec2(gl_FragCoord.xy)).rgb * share;
    scaled = vec4(min(c, HALF_MAX), 1.0);
}

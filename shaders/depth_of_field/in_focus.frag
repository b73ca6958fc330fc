#version 450 core
// Tiles in which nothing is blurred: as they are, bit for bit.
//
// Input:  colour_and_coc (colour_and_coc.frag).
// Output: the image, linear HDR, full resolution.
#include "eyes.glsl"
uniform eye_image colour_and_coc;

out vec4 blurred;

void main() {
    blurred = vec4(texel_of(colour_and_coc, ivec2(gl_FragCoord.xy)).rgb, 1.0);
}

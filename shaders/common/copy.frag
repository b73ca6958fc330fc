#version 450 core
// An image as it is, bit by bit: where nothing moves or restricts, of the tiles that are seen.
//
// Input:  image, of the same size.
// Output: the same.
#include "eyes.glsl"
uniform eye_image image;

out vec4 copied;

void main() {
    copied = texel_of(image, ivec2(gl_FragCoord.xy));
}

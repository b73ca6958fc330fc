#version 450 core
// Copies an image: the least that a pass over it can cost.
//
// Input:  an image of the target's size.
// Output: the same.
// Source: none; costs of other passes are given as multiples of this one's.

layout(binding = 0) uniform sampler2D source;
out vec4 copied;

void main() {
    copied = texelFetch(source, ivec2(gl_FragCoord.xy), 0);
}

#version 450 core
// Half of an image: each texel is the mean of the 2 x 2 that it covers.
//
// Input: level, read bilinearly. Output: rgb at half size (rounded up), texel t covers 2t and 2t + 1.
uniform sampler2D level;

out vec4 half_level;

void main() {
    half_level = textureLod(level, 2.0 * gl_FragCoord.xy / vec2(textureSize(level, 0)), 0.0);
}

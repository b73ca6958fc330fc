#version 450 core
// Blows up what was blurred at half resolution.
//
// Input: wide (taps_alike.frag at half size, rounded up), read bilinearly. Output: linear HDR.
uniform sampler2D wide;

out vec4 blurred;

void main() {
    blurred = vec4(textureLod(wide, gl_FragCoord.xy / (2.0 * vec2(textureSize(wide, 0))), 0.0).rgb, 1.0);
}

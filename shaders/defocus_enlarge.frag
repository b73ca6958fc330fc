#version 450 core
// Where all discs are wide and of one surface: what was blurred at half resolution, at full.
//
// Input:  wide_back (defocus_wide.frag), read bilinearly; its texel t is pixel 2 t.
// Output: the blurred image, linear HDR.
uniform sampler2D wide_back;

out vec4 blurred;

void main() {
    vec2 texel = 0.5 * (gl_FragCoord.xy + 0.5);
    blurred = vec4(textureLod(wide_back, texel / vec2(textureSize(wide_back, 0)), 0.0).rgb, 1.0);
}

#version 450 core
// Blows up what was blurred at half resolution.
//
// Input:  wide (rounded up), read bilinearly. SHIFT_PX: 0.0 where texel t covers pixels 2 t and
//         2 t + 1 (gather_taps.frag), 0.5 where it is pixel 2 t (gather_half_resolution.frag).
// Output: linear HDR.
uniform sampler2D wide;

out vec4 blurred;

void main() {
    vec2 texel = 0.5 * (gl_FragCoord.xy + SHIFT_PX);
    blurred = vec4(textureLod(wide, texel / vec2(textureSize(wide, 0)), 0.0).rgb, 1.0);
}

#version 450 core
// Tiles in which everything is blurred widely: half an image, enlarged.
//
// Input:  gathered (half_gather.frag), read bilinearly.
// Output: the blurred image, linear HDR, full resolution.
uniform sampler2D gathered;

out vec4 blurred;

void main() {
    vec2 place = gl_FragCoord.xy / (2.0 * vec2(textureSize(gathered, 0)));
    blurred = vec4(textureLod(gathered, place, 0.0).rgb, 1.0);
}

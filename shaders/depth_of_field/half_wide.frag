#version 450 core
// Tiles in which everything is blurred widely: half an image, enlarged.
//
// Input:  gathered (half_gather.frag), read bilinearly.
// Output: the blurred image, linear HDR, full resolution.
#include "eyes.glsl"
uniform eye_image gathered;

out vec4 blurred;

void main() {
    vec2 place = gl_FragCoord.xy / (2.0 * vec2(size_of(gathered)));
    blurred = vec4(filtered_at(gathered, place).rgb, 1.0);
}

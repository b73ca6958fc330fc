#version 450 core
// Tiles in which everything is blurred widely: half an image, enlarged.
//
// Input:  gathered (half_gather.frag), read between texels that are complete.
// Output: the blurred image, linear HDR, full resolution.
#include "eyes.glsl"
#include "half_gathered.glsl"

out vec4 blurred;

void main() {
    blurred = vec4(gathered_at(gl_FragCoord.xy).complete.rgb, 1.0);
}

#version 450 core
// Tiles in which everything is blurred widely: half an image, enlarged.
//
// Input:  gathered (half_gather.frag), read between texels that are complete; ALL_COMPLETE: all are.
// Output: the blurred image, linear HDR, full resolution.
#include "eyes.glsl"
#ifdef ALL_COMPLETE
uniform eye_image gathered;
#else
#include "half_gathered.glsl"
#endif

out vec4 blurred;

void main() {
#ifdef ALL_COMPLETE
    vec2 size = 2.0 * vec2(size_of(gathered));
    blurred = vec4(filtered_at(gathered, gl_FragCoord.xy / size).rgb, 1.0);
#else
    blurred = vec4(gathered_at(gl_FragCoord.xy).complete.rgb, 1.0);
#endif
}

#version 450 core
// Fast tiles, without a depth discontinuity within reach: the mean over each pixel's disc.
//
// Input:  colour_and_coc (colour_and_coc.frag; signed CoC RADIUS in px of image width); gathered
//         (gather.frag), WITH_HALF_RESOLUTION, for discs that are not summed over pixels.
// Output: the blurred image, linear HDR, full resolution.
#include "eyes.glsl"
#include "where.glsl"
#include "coc.glsl"
#include "discs.glsl"
#include "finite.glsl"
#include "levels.glsl"

uniform eye_image colour_and_coc;
#ifdef WITH_HALF_RESOLUTION
uniform eye_image gathered;
#endif

out vec4 blurred;

vec3 colour_of(eye_image image, ivec2 at) {
    return texel_of(image, at).rgb;
}
#define IMAGE eye_image
#include "footprint.glsl"

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 p = texel_of(colour_and_coc, pixel);
    float own_px = abs(p.a);
    bool wanted = own_px > 0.5;
    float wide = coarser_part(0, own_px);
    blurred = vec4(mean_over(colour_and_coc, vec2(pixel), own_px, wanted && wide < 1.0), 1.0);
#ifdef WITH_HALF_RESOLUTION
    WHERE (wanted && wide > 0.0) {
        vec2 at = gl_FragCoord.xy / vec2(size_of(colour_and_coc));
        blurred.rgb = mix(blurred.rgb, filtered_at(gathered, at).rgb, wide);
    }
#endif
    blurred.rgb = wanted ? blurred.rgb : p.rgb;
}

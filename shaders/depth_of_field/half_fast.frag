#version 450 core
// Tiles with small discs and without depth discontinuities: taps in the pixels, or half an image.
//
// Input:  colour_and_coc (colour_and_coc.frag; signed CoC RADIUS, px of image width, negative in front of the
//         focus), gathered (half_mean.frag); both read between texels.
// Output: the blurred image, linear HDR, full resolution.
#include "eyes.glsl"
#include "where.glsl"
#include "coc.glsl"
#include "half_gathered.glsl"

uniform float pixel_aspect_of_eye[EYES];
float pixel_aspect = pixel_aspect_of_eye[EYE];
uniform eye_image colour_and_coc;

#define TAPS 5
#define COUNTS(q) 1.0
#include "half_taps.glsl"

out vec4 blurred;

void main() {
    vec4 p = texel_of(colour_and_coc, ivec2(gl_FragCoord.xy));
    float own_px = abs(p.a);
    float wide = smoothstep(SMALL_FROM_PX, SMALL_PX, own_px), part = 0.0;
    vec3 light = vec3(0.0);
    WHERE (wide > 0.0) {
        Gathered soft = gathered_at(gl_FragCoord.xy);
        part = gathered_part(soft, wide);
        light = soft.complete.rgb;
    }
    blurred = vec4(min(mix(mean_of_taps(p, own_px > 0.5 && part < 1.0), light, part), HALF_MAX), 1.0);
}

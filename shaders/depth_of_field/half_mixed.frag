#version 450 core
// Tiles with small discs, from taps in the pixels, and what is blurred widely, from half an image.
//
// Input:  colour_and_coc (colour_and_coc.frag; signed CoC RADIUS, px of image width, negative in front of the
//         focus), gathered (half_gather.frag); both read between texels.
// Output: the blurred image, linear HDR, full resolution.
#include "eyes.glsl"
#include "coc.glsl"
#include "half_gathered.glsl"

uniform float pixel_aspect_of_eye[EYES];
float pixel_aspect = pixel_aspect_of_eye[EYE];
uniform eye_image colour_and_coc;

vec4 p = texel_of(colour_and_coc, ivec2(gl_FragCoord.xy));
#define TAPS 8
#define COUNTS(q) (1.0 - nearer(p.a, q.a))
#include "half_taps.glsl"

out vec4 blurred;

void main() {
    float own_px = abs(p.a);
    Gathered soft = gathered_at(gl_FragCoord.xy);
    float part = gathered_part(soft, smoothstep(SMALL_FROM_PX, SMALL_PX, own_px));
    vec3 own = mean_of_taps(p, own_px > 0.5 && part < 1.0);
    vec3 covered = soft.part > ALL ? own : mix(own, soft.cover.rgb, soft.cover.a);
    blurred = vec4(part > 0.0 || soft.cover.a > 0.0 ? min(mix(covered, soft.complete.rgb, part), HALF_MAX) : own, 1.0);
}

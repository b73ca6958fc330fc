#version 450 core
// Tiles with small discs, from nine taps in the pixels, and what is blurred widely, from half an image.
//
// Input:  colour_and_coc (colour_and_coc.frag; signed CoC RADIUS, px of image width, negative in front of the
//         focus), gathered (half_gather.frag); both read between texels.
// Output: the blurred image, linear HDR, full resolution.
//
// SMALL_FROM_PX, SMALL_PX: between these radii a pixel goes from one to the other.
#include "eyes.glsl"
#include "coc.glsl"
#include "half_gathered.glsl"

uniform float pixel_aspect_of_eye[EYES];
float pixel_aspect = pixel_aspect_of_eye[EYE];
uniform eye_image colour_and_coc;

const vec2 SIXTEENTH_TURN = vec2(0.92388, 0.38268);  // cosine and sine of 22.5 degrees
const float SQRT_HALF = 0.70711;

out vec4 blurred;

const float SOME = 0.01, ALL = 0.99;  // of the four texels
const float READ_PX2 = 0.3;  // what bilinear reads add to the square of a radius

void main() {
    vec2 size = vec2(size_of(colour_and_coc));
    vec4 p = texel_of(colour_and_coc, ivec2(gl_FragCoord.xy));
    float own_px = abs(p.a);
    Gathered soft = gathered_at(gl_FragCoord.xy);
    float wide = smoothstep(SMALL_FROM_PX, SMALL_PX, own_px);
    // Beside what only covers, taps in the pixels are better than the few texels that are complete.
    float part = soft.part > ALL ? wide + soft.complete.a - wide * soft.complete.a
               : wide < 1.0 ? wide * soft.part * soft.part : soft.part > SOME ? 1.0 : 0.0;
    // The centre and eight on a ring have the second moment of a disc.
    vec2 away = 0.75 * sqrt(max(own_px * own_px - READ_PX2, 0.0)) * SIXTEENTH_TURN;
    int taps = own_px > 0.5 && part < 1.0 ? 8 : 0;
    vec4 sum = vec4(p.rgb, 1.0);
    for (int i = 0; i < taps; ++i) {
        vec4 q = filtered_at(colour_and_coc, (gl_FragCoord.xy + away * vec2(1.0, pixel_aspect)) / size);
        sum += (1.0 - nearer(p.a, q.a)) * vec4(q.rgb, 1.0);
        away = SQRT_HALF * vec2(away.x - away.y, away.x + away.y);
    }
    vec3 own = taps > 0 ? sum.rgb / sum.a : p.rgb;
    vec3 covered = soft.part > ALL ? own : mix(own, soft.cover.rgb, soft.cover.a);
    blurred = vec4(part > 0.0 || soft.cover.a > 0.0 ? min(mix(covered, soft.complete.rgb, part), HALF_MAX) : own, 1.0);
}

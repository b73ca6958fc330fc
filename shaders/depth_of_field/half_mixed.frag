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
flat in vec4 tile;  // of half_tile_dilate.frag

vec4 p = texel_of(colour_and_coc, ivec2(gl_FragCoord.xy));
#define TAPS 8
#define COUNTS(q) (1.0 - nearer(p.a, q.a))
#include "half_taps.glsl"

out vec4 blurred;

// What is nearer and spreads over the pixel where no disc is gathered: light and opacity, on the ring of the widest
// disc in front of the focus that comes here. What is in focus does not spread; a read between two surfaces does as far
// as it is the nearer one's.
vec4 cover_of_taps() {
    float widest_px = tile.g > SMALL_FROM_PX ? 0.0 : tile.r;
    int taps = widest_px > 0.5 ? TAPS : 0;
    vec2 away = first_tap(widest_px), size = vec2(size_of(colour_and_coc));
    vec4 sum = vec4(0.0);
    for (int i = 0; i < taps; ++i) {
        vec4 q = filtered_at(colour_and_coc, (gl_FragCoord.xy + away * vec2(1.0, pixel_aspect)) / size);
        float spreads = clamp(2.0 * (-q.a - 0.5) / max(widest_px - 0.5, 0.25), 0.0, 1.0);
        sum += spreads * nearer(p.a, q.a) * vec4(q.rgb, 1.0);
        away = TURN * away;
    }
    return sum / float(TAPS + 1);
}

void main() {
    float own_px = abs(p.a);
    Gathered soft = gathered_at(gl_FragCoord.xy);
    float part = gathered_part(soft, smoothstep(SMALL_FROM_PX, SMALL_PX, own_px));
    vec3 own = mean_of_taps(p, own_px > 0.5 && part < 1.0);
    vec4 near = cover_of_taps();
    own = near.a > 0.0 ? mix(own, near.rgb / near.a, near.a) : own;
    vec3 covered = soft.part > ALL ? own : mix(own, soft.cover.rgb, soft.cover.a);
    blurred = vec4(part > 0.0 || soft.cover.a > 0.0 ? min(mix(covered, soft.complete.rgb, part), HALF_MAX) : own, 1.0);
}

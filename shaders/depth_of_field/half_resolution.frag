#version 450 core
// Half of an image, with one radius for each 2x2 pixels, and half of that again.
//
// Input:  source: colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width, negative in
//         front of the focus); of LEVELS above half an image, the finer level.
// Output: rgb = mean of the pixels that exist, in which bright ones weigh less, 1 / (1 + brightest
//         channel), so that one alone does not flicker, and on LEVELS all the same; a = RADIUS, px of the
//         whole image. Size / 2, rounded up.
//
// BY_RADIUS: pixels count as much as they are blurred, and the radius is their mean. Without it, it is
//         the least, which is the foremost pixel's, and 0 below IN_FOCUS_PX.
// NumPy twin: tests/oracles/half_resolution.py. As the prefilters of KinoBokeh and of Filament, and
// Filament's levels.
#include "eyes.glsl"
uniform eye_image source;

out vec4 half_image;

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    ivec2 last = size_of(source) - 1;
    vec4 blurred = vec4(0.0), any_pixel = vec4(0.0);
    float sum_px = 0.0, least_px = HALF_MAX, pixels = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 pixel = first + ivec2(i & 1, i >> 1);
        if (any(greaterThan(pixel, last)))
            continue;
        vec4 p = texel_of(source, pixel);
        vec4 share = vec4(p.rgb, 1.0);
#ifndef LEVELS
        share /= 1.0 + max(p.r, max(p.g, p.b));
#endif
        any_pixel += share;
        blurred += abs(p.a) * share;
        sum_px += p.a;
        least_px = min(least_px, p.a);
        pixels += 1.0;
    }
#ifdef BY_RADIUS
    vec4 sum = blurred.a > 0.0 ? blurred : any_pixel;
    float radius_px = sum_px / pixels;
#else
    vec4 sum = any_pixel;
    float radius_px = abs(least_px) < IN_FOCUS_PX ? 0.0 : least_px;
#endif
    half_image = vec4(min(sum.rgb / sum.a, HALF_MAX), radius_px);
}

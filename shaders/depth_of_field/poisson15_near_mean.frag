#version 450 core
// How blurred a cell of CELL x CELL pixels is by what lies in front of the focus.
//
// Input:  colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width, negative in front).
// Output: r = mean of the foreground's radii, positive; 0 where nothing is in front. Size / CELL, rounded
//         up: cells at the border average the pixels that exist.
// NumPy twin: tests/oracles/poisson_taps.py. Mantiuk et al. 2011, section 4: "down-sampled to 1/8th
// of its size in every dimension".
#include "eyes.glsl"
uniform eye_image colour_and_coc;

out float near_mean;

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * CELL;
    ivec2 end = min(first + CELL, size_of(colour_and_coc));
    float sum = 0.0;
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x)
            sum += max(-texel_of(colour_and_coc, ivec2(x, y)).a, 0.0);
    near_mean = sum / float((end.x - first.x) * (end.y - first.y));
}

#version 450 core
// Near things, drawn over the picture of what lies behind them.
//
// Input:  near (near_gather.frag), at half resolution; WITH_PIXELS: near_pixels (near_pixels.frag); drawn on tiles of
//         class NEAR.
// Output: rgb and opacity, premultiplied, to be blended.
#include "eyes.glsl"
#include "near.glsl"
#include "near_over.glsl"
uniform eye_image near;
#ifdef WITH_PIXELS
uniform eye_image near_pixels;
#endif

out vec4 over;

void main() {
#ifdef WITH_PIXELS
    over = near_over(near, near_pixels, ivec2(gl_FragCoord.xy));
#else
    over = near_half(near, ivec2(gl_FragCoord.xy));
#endif
}

#version 450 core
// Near things, drawn over the picture of what lies behind them.
//
// Input:  near (near_gather.frag), at half resolution; drawn on tiles of class NEAR.
// Output: rgb and opacity, premultiplied, to be blended.
#include "eyes.glsl"
#include "near_over.glsl"
uniform eye_image near;

out vec4 over;

void main() {
    over = near_over(near, ivec2(gl_FragCoord.xy));
}

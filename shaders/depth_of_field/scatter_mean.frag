#version 450 core
// What arrived at a pixel over how much arrived: the image Q of Algorithm 1.
//
// Input:  shares (rgb = sum of colour * weight, a = sum of weights, 32-bit float).
// Output: linear HDR. No amount is a radius. A pixel's own disc always arrives, so a > 0.
// Carnegie & Rhee 2015, Algorithm 1; that the blend is normalised is our reading of it.
#include "eyes.glsl"
uniform eye_image shares;

out vec4 blurred;

void main() {
    vec4 sum = texel_of(shares, ivec2(gl_FragCoord.xy));
    blurred = vec4(min(sum.rgb / sum.a, HALF_MAX), 1.0);
}

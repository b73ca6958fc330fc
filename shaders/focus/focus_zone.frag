#version 450 core
// Focus from the means over the autofocus zone.
//
// Input:  means: 1x1, x = mean of weight * value, y = mean weight (focus_weights.frag).
// Output: include/refocus.glsl; no rays.
// Source: Hillaire et al. 2008, Eq. 3.
#include "refocus_law.glsl"
#include "refocus.glsl"

uniform sampler2D means;
#ifndef MEAN_DIOPTRES
uniform float infinity_m;
#endif

void main() {
    vec4 mean = texelFetch(means, ivec2(0), 0);
#ifdef MEAN_DIOPTRES
    refocus(mean.y / mean.x, 0);
#else
    refocus(infinity_m * (mean.x / mean.y), 0);
#endif
}

#version 450 core
// Focus from what the autofocus zone was reduced to.
//
// Input:  reduced: 1x1, x = mean of weight * value, y = mean weight (focus_weights.frag);
//         EXTREME: x = near_m / distance (focus_extreme.frag).
// Output: include/refocus.glsl; no rays.
// Source: Hillaire et al. 2008, Eq. 3.
#include "refocus_law.glsl"
#include "refocus.glsl"

uniform sampler2D reduced;
#if defined(EXTREME)
uniform float near_m;
#elif !defined(MEAN_DIOPTRES)
uniform float infinity_m;
#endif

void main() {
    vec4 zone = texelFetch(reduced, ivec2(0), 0);
#if defined(EXTREME)
    refocus(near_m / zone.x, 0);
#elif defined(MEAN_DIOPTRES)
    refocus(zone.y / zone.x, 0);
#else
    refocus(infinity_m * (zone.x / zone.y), 0);
#endif
}

#version 450 core
// What each pixel of the autofocus zone says about the focus, and how much it counts.
//
// Input:  include/zone_depth.glsl; semantic weight of what the zone shows.
// Output: x = weight * value, y = weight. The value is the distance over infinity_m, at most 1, so
//         that nothing overflows; MEAN_DIOPTRES: one over the distance in metres.
// Twin:   vrcomfort/optics/autofocus_zone.py.
// Source: Hillaire et al. 2008, Eq. 2 (W_S, W_G).
#include "zone_depth.glsl"

uniform sampler2D semantic;
uniform vec2 semantic_limits;  // W_S min, max
uniform vec2 gauss_limits;     // W_G min (border), max (centre)

in vec2 uv;
out vec4 weighted;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float z = zone_depth(pixel, uv);
#ifdef MEAN_DIOPTRES
    float value = z / near_m;
#else
    float value = near_m / z / infinity_m;
#endif
    vec2 away = 2.0 * uv - 1.0;  // half sides
    float fall = pow(gauss_limits.x / gauss_limits.y, dot(away, away));
    float gauss = max(gauss_limits.y * fall, gauss_limits.x);
    float weight = gauss * clamp(texelFetch(semantic, pixel, 0).r, semantic_limits.x, semantic_limits.y);
    weighted = vec4(weight * value, weight, 0.0, 0.0);
}

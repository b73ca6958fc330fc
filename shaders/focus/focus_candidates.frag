#version 450 core
// How far each pixel of the autofocus zone is, and whether it comes before the others.
//
// Input:  include/zone_depth.glsl; semantic weight of what the zone shows.
// Output: x = near_m / distance; y = 1 where the weight is above the least there is, else 0.
// Twin:   vrcomfort/optics/autofocus_zone.py.
// Source: Hillaire et al. 2008, "The autofocus zone"; that weights choose the pixels is ours.
#include "zone_depth.glsl"

uniform sampler2D semantic;
uniform vec2 semantic_limits;  // W_S min, max

in vec2 uv;
out vec4 candidate;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float weight = min(texelFetch(semantic, pixel, 0).r, semantic_limits.y);
    candidate = vec4(zone_depth(pixel, uv), weight > semantic_limits.x ? 1.0 : 0.0, 0.0, 0.0);
}

#version 450 core
// Puts the circle of confusion beside the colour, so that one fetch gives a tap all it needs.
//
// Input:  colour (linear HDR), depth, focus (include/coc_of_depth.glsl).
// Output: rgb = colour, finite; a = signed CoC RADIUS in pixels of image width, negative in front
//         of the focus. Full resolution; a half float holds 11 px to 1/256 px.
// Source: Carnegie & Rhee 2015, Algorithm 1; PERIPHERAL: Hillaire et al. 2008, Eq. 5 and 6.
#include "coc.glsl"
#include "coc_of_depth.glsl"

uniform sampler2D colour;

out vec4 point;

const float HALF_MAX = 65504.0;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 c = texelFetch(colour, pixel, 0).rgb;
    point.rgb = clamp(mix(c, vec3(0.0), isnan(c)), 0.0, HALF_MAX);
    point.a = radius_of(pixel);
}

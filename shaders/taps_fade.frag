#version 450 core
// Small discs, two reads each: the image cross-fades into half of it, blown up.
//
// Input:  depth, focus (include/defocus.glsl); colour (linear HDR); halves: half of it
//         (taps_shrink.frag), read bilinearly.
// Output: rgb, linear HDR.
//
// Half of the image, blown up, is as blurred as a disc of 2 px (optics/pyramid.py); the cross-fade is
// linear in variance, from the 0.5 px that change nothing. Twin: optics.taps.fade. Pixels that are not
// square get the disc's area.
#include "coc.glsl"
#include "defocus.glsl"

uniform sampler2D colour;
uniform sampler2D halves;
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

const float LEAST_PX2 = 0.25;
const float HALF_PX2 = 4.0;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float radius = radius_of(pixel);
    float opacity = (radius * radius * pixel_aspect - LEAST_PX2) / (HALF_PX2 - LEAST_PX2);
    vec4 sharp = texelFetch(colour, pixel, 0);
    vec4 soft = textureLod(halves, gl_FragCoord.xy / (2.0 * vec2(textureSize(halves, 0))), 0.0);
    blurred = mix(sharp, soft, clamp(opacity, 0.0, 1.0));
}

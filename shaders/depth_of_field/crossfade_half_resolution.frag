#version 450 core
// Small discs, two reads each: the image cross-fades into half of it, blown up.
//
// Input:  colour (linear HDR); half_resolution: half of it, and RADIUS (px of image width;
//         downsample.frag),
//         read bilinearly.
// Output: rgb, linear HDR.
//
// Half of the image, blown up, is as blurred as a disc of 2 px (optics/pyramid.py); the cross-fade is
// linear in variance, from the 0.5 px that change nothing. Twin: tests/oracles/taps.py. Pixels that are not
// square get the disc's area.
uniform sampler2D colour;
uniform sampler2D half_resolution;
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

const float LEAST_PX2 = 0.25;
const float HALF_PX2 = 4.0;

void main() {
    vec4 sharp = texelFetch(colour, ivec2(gl_FragCoord.xy), 0);
    vec2 size = vec2(textureSize(half_resolution, 0));
    vec4 soft = textureLod(half_resolution, gl_FragCoord.xy / (2.0 * size), 0.0);
    float radius = max(soft.a, sqrt(LEAST_PX2 / pixel_aspect));
    float opacity = (radius * radius * pixel_aspect - LEAST_PX2) / (HALF_PX2 - LEAST_PX2);
    blurred = vec4(mix(sharp.rgb, soft.rgb, clamp(opacity, 0.0, 1.0)), sharp.a);
}

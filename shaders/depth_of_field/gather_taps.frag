#version 450 core
// Wide discs where everything is about as blurred: the mean of a few bilinear reads over each one.
//
// Input:  depth, focus (include/coc_of_depth.glsl); level: a half or a quarter of the image (linear HDR),
//         whose texels are LEVEL px wide, drawn into a target whose texels are SHOWN px wide.
//         RADII: the level has a RADIUS (px of image width) in a, and texels as wide as the target's;
//         no lens is needed. offsets: TAPS points of the unit disc.
// Output: rgb, linear HDR.
//
// Reads blur by themselves: the pattern is narrower than the disc (EXTENT_*, twin: tap_extent_px).
#ifndef RADII
#include "coc.glsl"
#include "coc_of_depth.glsl"
#endif

uniform sampler2D level;
uniform vec2 offsets[TAPS];
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

void main() {
    vec2 centre_px = SHOWN * gl_FragCoord.xy;
    vec2 size_px = LEVEL * vec2(textureSize(level, 0));
#ifdef RADII
    float radius = texelFetch(level, ivec2(gl_FragCoord.xy), 0).a;
#else
    float radius = radius_of(min(ivec2(centre_px), textureSize(depth, 0) - 1));
#endif
    vec2 extent = radius * vec2(1.0, pixel_aspect);
    vec2 far = sqrt(max(extent * extent - EXTENT_FAR_PX2, 0.0));
    vec2 near = min(max(extent * extent - EXTENT_NEAR_PX2, 0.0) * EXTENT_PER_PX, EXTENT_NEAR_PX);
    extent = max(far, near) / size_px;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < TAPS; ++i)
        sum += textureLod(level, centre_px / size_px + extent * offsets[i], 0.0).rgb;
    blurred = vec4(min(sum / float(TAPS), 65504.0), 1.0);
}

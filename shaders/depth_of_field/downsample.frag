#version 450 core
// Half of an image: each texel is the mean of the 2 x 2 that it covers.
//
// Input:  level, read bilinearly. RADII: depth, read bilinearly, and focus (include/coc_of_depth.glsl).
// Output: rgb at half size (rounded up), texel t covers 2t and 2t + 1; RADII: a = RADIUS (px of image
//         width) in the middle of it. Radii are affine in depth: between its texels they are right.
#ifdef RADII
#include "coc.glsl"
#include "coc_of_depth.glsl"
#endif

uniform sampler2D level;

out vec4 half_level;

void main() {
    vec2 uv = 2.0 * gl_FragCoord.xy / vec2(textureSize(level, 0));
    half_level = textureLod(level, uv, 0.0);
#ifdef RADII
    half_level.a = abs(radius_at(textureLod(depth, uv, 0.0).r, uv));
#endif
}

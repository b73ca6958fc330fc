#version 450 core
// Opens the depth buffer where something near is to give way to what lies behind it.
//
// Input:  depth (resolved), focus (include/coc_of_depth.glsl); drawn on tiles of class BEHIND.
// Output: depth 0, infinity, of a near pixel; others keep theirs, 1, which nothing passes.
#include "coc.glsl"
#include "coc_of_depth.glsl"
#include "near.glsl"

uniform sampler2D depth;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (radius_at(texelFetch(depth, pixel, 0).r, gl_FragCoord.xy / vec2(textureSize(depth, 0))) > -BEHIND_PX)
        discard;
    gl_FragDepth = 0.0;
}

#version 450 core
// Opens the depth buffer where something near is to give way to what lies behind it.
//
// Input:  colour_and_coc (colour_and_coc.frag); limit (near_limit.frag); drawn on tiles of class BEHIND. NEXT: depth
//         (resolved).
// Output: depth 0, infinity, of a near pixel, and how near what is drawn there may be (reverse-Z depth): not near at
//         all; NEXT, well behind what is seen. Other pixels keep their depth, 1, which nothing passes.
#include "near.glsl"

uniform sampler2D colour_and_coc;
uniform sampler2D limit;
#ifdef NEXT
uniform sampler2D depth;
#endif

out float nearest;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float radius_px = texelFetch(colour_and_coc, pixel, 0).a;
    if (radius_px > -BEHIND_PX)
        discard;
    gl_FragDepth = 0.0;
    vec2 corner = gl_FragCoord.xy / float(TILE) + 0.5;
    nearest = textureLod(limit, corner / vec2(textureSize(limit, 0)), 0.0).r;
#ifdef NEXT
    // Radii are even in depth, or nearly so.
    float part = (well_behind_px(radius_px) + BEHIND_PX) / min(radius_px + BEHIND_PX, -1e-3);
    nearest = mix(nearest, texelFetch(depth, pixel, 0).r, clamp(part, 0.0, 1.0));
#endif
}

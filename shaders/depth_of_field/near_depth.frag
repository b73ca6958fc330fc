#version 450 core
// Opens the depth buffer where something near is to give way to what lies behind it.
//
// Input:  colour_and_coc (colour_and_coc.frag); limit (near_limit.frag); drawn on tiles of class BEHIND. NEXT: depth
//         (resolved).
// Output: depth 0, infinity, of a near pixel, and how near what is drawn there may be (reverse-Z depth): not near at
//         all; NEXT, well behind what is seen. Other pixels keep their depth, 1, which nothing passes.
#include "eyes.glsl"
#include "near.glsl"

uniform eye_image colour_and_coc;
uniform eye_image limit;
#ifdef NEXT
uniform eye_image depth;
#endif

out float nearest;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float radius_px = texel_of(colour_and_coc, pixel).a;
    if (radius_px > -BEHIND_PX)
        discard;
    gl_FragDepth = 0.0;
    vec2 corner = gl_FragCoord.xy / float(TILE) + 0.5;
    nearest = filtered_at(limit, corner / vec2(size_of(limit))).r;
#ifdef NEXT
    // Radii are even in depth, or nearly so.
    float part = (well_behind_px(radius_px) + BEHIND_PX) / min(radius_px + BEHIND_PX, -1e-3);
    nearest = mix(nearest, texel_of(depth, pixel).r, clamp(part, 0.0, 1.0));
#endif
}

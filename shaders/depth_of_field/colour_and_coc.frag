#version 450 core
// Puts the circle of confusion beside the colour, so that one fetch gives a tap all it needs: where the
// colour is not the scene's own, whose samples are resolved with it (scene/resolve.frag).
//
// Input:  colour (linear HDR), depth, focus (include/coc_of_depth.glsl). BEHIND_NEAR: what was drawn behind near
//         things, with depth 1 everywhere else (near_depth.frag); the rest is left as it is.
// Output: rgb = colour, finite; a = signed CoC RADIUS in pixels of image width, negative in front
//         of the focus. Full resolution; a half float holds 11 px to 1/256 px.
// Source: Carnegie & Rhee 2015, Algorithm 1; PERIPHERAL: Hillaire et al. 2008, Eq. 5 and 6.
#include "eyes.glsl"
#include "coc.glsl"
#include "coc_of_depth.glsl"
#include "coverage.glsl"

#include "finite.glsl"

uniform eye_image colour;
uniform eye_image depth;

out vec4 point;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float z = texel_of(depth, pixel).r;
#ifdef BEHIND_NEAR
    if (z == 1.0)
        discard;
#endif
    point.rgb = finite(texel_of(colour, pixel).rgb);
    point.a = radius_at(z, gl_FragCoord.xy / vec2(size_of(depth)));
#ifdef WITH_COVERAGE
    point.a = with_coverage(point.a, 1.0);  // what is behind has one sample
#endif
}

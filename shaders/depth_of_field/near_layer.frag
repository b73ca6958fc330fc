#version 450 core
// A coarser level of what is near: nothing else is in it.
//
// Input:  FROM_PIXELS: colour_and_coc (colour_and_coc.frag); else finer and finer_radius, a level as fine again.
// Output: texel t holds texels 2t and 2t + 1 of the input: rgb and coverage, premultiplied by coverage;
//         signed RADIUS (px of image width), times coverage.
#include "near.glsl"

uniform sampler2D finer;
#ifndef FROM_PIXELS
uniform sampler2D finer_radius;
#endif

layout(location = 0) out vec4 light;
layout(location = 1) out float radius;

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy), last = textureSize(finer, 0) - 1;
    light = vec4(0.0);
    radius = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 at = min(first + ivec2(i & 1, i >> 1), last);
        vec4 texel = texelFetch(finer, at, 0);
#ifdef FROM_PIXELS
        float part = near_part(texel.a);
        light += 0.25 * part * vec4(texel.rgb, 1.0);
        radius += 0.25 * part * texel.a;
#else
        light += 0.25 * texel;
        radius += 0.25 * texelFetch(finer_radius, at, 0).r;
#endif
    }
}

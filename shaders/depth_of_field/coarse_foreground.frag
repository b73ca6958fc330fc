#version 450 core
// The nearest wide discs in each texel of LEVEL px, and how much of it they cover: thin fronts keep their
// light, wherever they lie among texels.
//
// Input:  colour_and_coc (colour_and_coc.frag; signed CoC RADIUS, px of image width, negative in
//         front of the focus).
// Output: rgb = mean of the nearest surface with discs above SMALL_PX; a = its radius and its part of a
//         tent around pixel LEVEL t, which adds up to 1 for each pixel (packed_foreground).
#include "coc.glsl"
#include "coarse.glsl"

uniform sampler2D colour_and_coc;

out vec4 point;

const float NOTHING_PX = 1e4;

void main() {
    ivec2 last = textureSize(colour_and_coc, 0) - 1;
    ivec2 middle = LEVEL * ivec2(gl_FragCoord.xy);
    float nearest = NOTHING_PX;
    for (int y = 1 - LEVEL; y < LEVEL; ++y)
        for (int x = 1 - LEVEL; x < LEVEL; ++x) {
            float radius = texelFetch(colour_and_coc, clamp(middle + ivec2(x, y), ivec2(0), last), 0).a;
            nearest = abs(radius) > SMALL_PX ? min(nearest, radius) : nearest;
        }
    vec4 sum = vec4(0.0);
    for (int y = 1 - LEVEL; y < LEVEL; ++y)
        for (int x = 1 - LEVEL; x < LEVEL; ++x) {
            vec4 q = texelFetch(colour_and_coc, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            float tent = float((LEVEL - abs(x)) * (LEVEL - abs(y)));
            float like = abs(q.a) > SMALL_PX ? 1.0 - nearer(q.a, nearest) : 0.0;
            sum += tent * like * vec4(q.rgb, 1.0);
        }
    const float WHOLE = float(LEVEL * LEVEL * LEVEL * LEVEL);
    vec3 colour = sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
    point = vec4(colour, packed_foreground(nearest, sum.a / WHOLE));
}

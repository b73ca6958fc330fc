#version 450 core
// Half of an image: of each 2x2 texels one surface, a blurred one rather than one in focus.
//
// Input:  finer: colour_and_coc (colour_and_coc.frag; signed CoC RADIUS, px of image width, negative in
//         front of the focus), or a result of this pass.
// Output: rgb = mean over the texels of that surface, a = their mean RADIUS, its last bit 1 where a pixel is
//         less blurred than SMALL_PX. Size / 2, rounded up.
//
// Texels in focus hardly count: no halo, and what is blurred goes on behind them.
#include "coc.glsl"
#include "finite.glsl"

uniform sampler2D finer;

const float SHARP_WEIGHT = 0.001;  // of what is in focus, which has no part in a blur unless it is alone

out vec4 surface;

bool has_small(float radius) {
#ifdef FROM_SURFACES
    return (packHalf2x16(vec2(radius, 0.0)) & 1u) != 0u;
#else
    return abs(radius) < SMALL_PX;
#endif
}

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(finer, 0) - 1;
    vec4 texels[4];
    float farthest = -1e4;
    bool small = false;
    for (int i = 0; i < 4; ++i) {
        texels[i] = texelFetch(finer, min(first + ivec2(i & 1, i >> 1), last), 0);
        farthest = max(farthest, texels[i].a);
        small = small || has_small(texels[i].a);
    }
    // Surfaces that are both blurred behind the focus share a texel: thin ones would be lost.
    float border = min(farthest - 1.5 * margin_px(farthest), 0.5);
    vec4 front = vec4(0.0), back = vec4(0.0);
    vec2 parts = vec2(0.0);
    for (int i = 0; i < 4; ++i) {
        float weight = mix(SHARP_WEIGHT, 1.0, clamp(abs(texels[i].a) - 0.25, 0.0, 1.0));
        bool nearer = texels[i].a < border;
        front += nearer ? weight * texels[i] : vec4(0.0);
        back += nearer ? vec4(0.0) : weight * texels[i];
        parts += nearer ? vec2(weight, 0.0) : vec2(0.0, weight);
    }
    vec4 mean = parts.x > parts.y ? front / parts.x : back / parts.y;
    uint radius = (packHalf2x16(vec2(mean.a, 0.0)) & ~1u) | (small ? 1u : 0u);
    surface = vec4(min(UP * mean.rgb, HALF_MAX), unpackHalf2x16(radius).x);
}

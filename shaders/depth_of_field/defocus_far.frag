#version 450 core
// Very wide blur, one layer at a time, from every texel of LEVEL px that a disc covers: what is behind, or
// (FRONT) what is in front.
//
// Input:  points_far (defocus_half.frag, again and again), reach (defocus_reach.frag); FRONT: fronts_far
//         (defocus_fronts.frag). With FAR_PX: wide_back, wide_front, drawn as here on texels twice as wide,
//         where discs are wider than that.
//         Signed CoC RADIUS in px of image width, negative in front of the focus.
// Output: as defocus_wide.frag.
//
// A ring of few taps would make a ring of dots of a lamp.
#include "coc.glsl"
#include "gather.glsl"
#include "far.glsl"
#include "far_sum.glsl"
#ifdef FAR_PX
#include "wide_layers.glsl"
#endif

out vec4 layer;

ivec2 texel = ivec2(gl_FragCoord.xy);

#ifdef FRONT
uniform sampler2D points_far;
uniform sampler2D reach;

void main() {
    float p = texelFetch(points_far, texel, 0).a;
    vec4 tile = texelFetch(reach, LEVEL * texel / TILE, 0);
    bool has_front = tile.a < p - margin_px(p);
    float front_px = has_front ? max(-tile.a, p) : 0.0;
#ifdef FAR_PX
    bool far = max(abs(p), front_px) > FAR_PX;
    bool mixed = suffices(mix_layers(texel, p, far, true, abs(p) > FAR_PX));
    layer = mixed ? mixed_front : sum_over(has_front, vec2(texel), p, front_px);
#else
    layer = sum_over(has_front, vec2(texel), p, front_px);
#endif
}
#else
void main() {
    layer = texelFetch(points_far, texel, 0);
    float p = layer.a;
    bool wide = abs(p) > SMALL_PX;
#ifdef FAR_PX
    bool mixed = suffices(mix_layers(texel, p, abs(p) > FAR_PX, false, true));
    wide = wide && !mixed;
    layer.rgb = mixed ? mixed_back.rgb : layer.rgb;
#endif
    vec4 sum = sum_over(wide, vec2(texel), p, abs(p));
    layer.rgb = wide ? min(sum.rgb / sum.a, 65504.0) : layer.rgb;
}
#endif

#version 450 core
// Very wide blur, one layer at a time, from every texel of LEVEL px that a disc covers: what is behind, or
// (FOREGROUND) what is in front.
//
// Input:  coarse_colour_and_coc (coc_downsample_tent.frag, again and again), dilated
//         (coc_tile_dilate.frag); FOREGROUND: coarse_foreground (coarse_foreground.frag). With
//         COARSE_PX: wide_background, wide_foreground, drawn as here on texels twice as wide, where
//         discs are wider than that.
//         Signed CoC RADIUS in px of image width, negative in front of the focus.
// Output: as gather_half_resolution.frag.
//
// A ring of few taps would make a ring of dots of a lamp.
#include "coc.glsl"
#include "gather.glsl"
#include "coarse.glsl"
#include "coarse_gather.glsl"
#ifdef COARSE_PX
#include "bilateral_upsample.glsl"
#endif

out vec4 layer;

ivec2 texel = ivec2(gl_FragCoord.xy);

#ifdef FOREGROUND
uniform sampler2D coarse_colour_and_coc;
uniform sampler2D dilated;

void main() {
    float p = texelFetch(coarse_colour_and_coc, texel, 0).a;
    vec4 tile = texelFetch(dilated, LEVEL * texel / TILE, 0);
    bool has_foreground = tile.a < p - margin_px(p);
    float foreground_px = has_foreground ? max(-tile.a, p) : 0.0;
#ifdef COARSE_PX
    bool very_wide = max(abs(p), foreground_px) > COARSE_PX;
    bool mixed = suffices(bilateral_upsample(texel, p, very_wide, true, abs(p) > COARSE_PX));
    layer = mixed ? upsampled_foreground : sum_over(has_foreground, vec2(texel), p, foreground_px);
#else
    layer = sum_over(has_foreground, vec2(texel), p, foreground_px);
#endif
}
#else
void main() {
    layer = texelFetch(coarse_colour_and_coc, texel, 0);
    float p = layer.a;
    bool wide = abs(p) > SMALL_PX;
#ifdef COARSE_PX
    bool mixed = suffices(bilateral_upsample(texel, p, abs(p) > COARSE_PX, false, true));
    wide = wide && !mixed;
    layer.rgb = mixed ? upsampled_background.rgb : layer.rgb;
#endif
    vec4 sum = sum_over(wide, vec2(texel), p, abs(p));
    layer.rgb = wide ? min(sum.rgb / sum.a, 65504.0) : layer.rgb;
}
#endif

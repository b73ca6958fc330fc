// Wide blur that was drawn on texels twice as wide, mixed from those around that are on one's surface.
//
// Texel t of the layers lies on texel (or pixel) 2 t of this image. Radii are signed, in pixels of image
// width. Include after coc.glsl. The layers: defocus_wide.frag, defocus_far.frag.

uniform sampler2D wide_back;
uniform sampler2D wide_front;

// All four texels around; beside a rim, where discs are hardly wider than texels, those of one side would
// draw a line along it.
const float ALL_AROUND = 3.5;
// Discs of many texels hardly change from one to the next: what there is of this surface will do.
const float ANY_AROUND = 0.5;
// Where there is none, taps are far apart, and p is one of many pixels in the middle: with the weight of
// a tap a lone lamp would stay a dot.
const float LONE = 0.01;

vec4 mixed_back;
vec4 mixed_front;

// False, and nothing mixed, unless so many of the texels around are on the surface of this radius.
bool mix_layers(ivec2 at, float signed_px, bool wanted, bool with_front, float least) {
    ivec2 last_wide = textureSize(wide_back, 0) - 1;
    float tolerance = 1.0 / (2.0 * margin_px(signed_px));
    vec4 backs = vec4(0.0), fronts = vec4(0.0);
    ivec2 odd = at & 1;
    for (int i = wanted ? 0 : 4; i < 4; ++i) {
        ivec2 there = min(at / 2 + (ivec2(i, i >> 1) & odd), last_wide);
        vec4 b = texelFetch(wide_back, there, 0);
        float like = clamp(2.0 - abs(b.a - signed_px) * tolerance, 0.0, 1.0);
        backs += like * vec4(b.rgb, 1.0);
        if (with_front)
            fronts += like * texelFetch(wide_front, there, 0);
    }
    if (backs.a < least)
        return false;
    mixed_back = vec4(backs.rgb / backs.a, 1.0);
    mixed_front = fronts / backs.a;
    return true;
}

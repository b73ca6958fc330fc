// Wide blur that was drawn on texels twice as wide, mixed from those around that are on one's surface.
//
// Texel t of the layers lies on texel (or pixel) 2 t of this image. Radii are signed where they are called
// so, in pixels of image width. Include after coc.glsl. The layers: gather_half_resolution.frag,
// gather_coarse.frag.

uniform sampler2D wide_background;
uniform sampler2D wide_foreground;

// How much of the four texels around must be on one's surface. All of it; beside a rim, where discs are
// hardly wider than texels, those of one side would draw a line along it.
const float ALL_AROUND = 3.5;
// Very wide discs hardly change from one texel to the next: what there is will do.
const float SOME_AROUND = 0.5;
// Where one's own disc is very wide and there is none, what is behind will do: it sees one as a foreground.
const float BEHIND = 1e-3;

vec4 upsampled_background;
vec4 upsampled_foreground;

// Whether texels twice as fine do with the mixture: not where there is a part of one's surface only.
bool suffices(float around) {
    return around >= ALL_AROUND || (around >= BEHIND && around < SOME_AROUND);
}

// Mixes the texels around on the surface of this radius, if very_wide also others; returns how much of the
// four it was.
float bilateral_upsample(ivec2 at, float signed_px, bool wanted, bool with_foreground, bool very_wide) {
    ivec2 last_wide = textureSize(wide_background, 0) - 1;
    float tolerance = 1.0 / (2.0 * margin_px(signed_px));
    float behind = very_wide ? BEHIND : 0.0;
    vec4 backgrounds = vec4(0.0), foregrounds = vec4(0.0);
    ivec2 odd = at & 1;
    for (int i = wanted ? 0 : 4; i < 4; ++i) {
        ivec2 there = min(at / 2 + (ivec2(i, i >> 1) & odd), last_wide);
        vec4 b = texelFetch(wide_background, there, 0);
        float like = clamp(2.0 - abs(b.a - signed_px) * tolerance, b.a > signed_px ? behind : 0.0, 1.0);
        backgrounds += like * vec4(b.rgb, 1.0);
        if (with_foreground)
            foregrounds += like * texelFetch(wide_foreground, there, 0);
    }
    float all = max(backgrounds.a, BEHIND);
    upsampled_background = vec4(backgrounds.rgb / all, 1.0);
    upsampled_foreground = foregrounds / all;
    return backgrounds.a;
}

#version 450 core
// Wide blur at half resolution, one layer at a time: what is behind, or (FOREGROUND) what is in front.
//
// Input:  colour_and_coc, half_resolution (coc_downsample_tent.frag), dilated (coc_tile_dilate.frag);
//         signed CoC RADIUS in px.
// Output: background: rgb = mean over the texel's own disc of its surface and those behind it,
//               a = the texel's radius, by which full resolution tells surfaces apart;
//         FOREGROUND: rgb * opacity, opacity of the wide discs of nearer surfaces.
// Discs of more than COARSE_PX, if there is such a limit, come from wide_background and
// wide_foreground, whose texels are of LEVEL px (gather_coarse.frag): here their taps would lie far
// apart. Beside rims they are summed as there
// (coarse_colour_and_coc, coarse_foreground).
//
// Half resolution blurs by itself, but not across rims. So where there are none the discs are
// smaller by its variance: a disc of radius 2 px is half resolution itself. The layers:
// gather_composite.frag.
#include "coc.glsl"
#include "gather.glsl"
#ifdef COARSE_PX
#include "bilateral_upsample.glsl"
#include "coarse.glsl"
#include "coarse_gather.glsl"
#endif

uniform sampler2D colour_and_coc;
uniform sampler2D half_resolution;
uniform sampler2D dilated;

out vec4 layer;

// Taps lie about this far apart, in texels, until RINGS is reached.
const float SPACING = 1.0;

ivec2 texel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(half_resolution, 0) - 1;

// Taps near each other read full resolution: half of it would move rims by up to half a pixel.
vec4 tap(int i, float away, bool halved) {
    vec2 at = vec2(texel) + 0.5 + away * directions[i] * vec2(1.0, pixel_aspect);
    ivec2 whole = ivec2(floor(2.0 * at - 0.5));  // texel t is pixel 2 t
    return halved ? texelFetch(half_resolution, clamp(ivec2(at), ivec2(0), last), 0)
                  : texelFetch(colour_and_coc, clamp(whole, ivec2(0), textureSize(colour_and_coc, 0) - 1), 0);
}

#ifdef FOREGROUND
void main() {
    float p = texelFetch(half_resolution, texel, 0).a;
    vec4 tile = texelFetch(dilated, 2 * texel / TILE, 0);
    bool has_foreground = tile.a < p - margin_px(p);
    float foreground_px = has_foreground ? max(-tile.a, p) : 0.0;
    layer = vec4(0.0);
#ifdef COARSE_PX
    bool very_wide = max(abs(p), foreground_px) > COARSE_PX;
    float around = bilateral_upsample(texel, p, very_wide, true, abs(p) > COARSE_PX);
    bool mixed = very_wide && suffices(around), summed = very_wide && !mixed && around > 0.0;
    layer = mixed ? upsampled_foreground
          : sum_over(summed && has_foreground, 0.5 * vec2(texel), p, foreground_px);
    if (mixed || summed)
        return;
#endif
    if (!has_foreground)
        return;
    float disc = 0.5 * foreground_px;
    int rings = ring_count(disc, SPACING);
    float spacing = disc / (float(rings) + 0.5);
    float area = 0.25 * PI * spacing * spacing;
    int i = 0;
    for (int ring = 1; ring <= rings; ++ring) {
        float away = ring_radius(ring, spacing);
        for (int k = 0; k < 8 * ring; ++k, ++i) {
            vec4 q = tap(i, away, spacing > SPACING);
            float is_foreground = nearer(p, q.a);
            if (is_foreground <= 0.0 || abs(q.a) <= SMALL_PX)
                continue;
            float over = is_foreground * foreground_opacity(away, 0.5 * abs(q.a), spacing, area);
            layer += over * vec4(q.rgb, 1.0);
        }
    }
}
#else
void main() {
    vec4 p = texelFetch(half_resolution, texel, 0);
    layer = p;
    vec4 tile = texelFetch(dilated, 2 * texel / TILE, 0);
    bool alike = is_alike(p.a, tile, 1.5);
    if (abs(p.a) <= SMALL_PX)
        return;
#ifdef COARSE_PX
    bool very_wide = abs(p.a) > COARSE_PX;
    float around = bilateral_upsample(texel, p.a, very_wide, false, true);
    bool mixed = very_wide && suffices(around), summed = very_wide && !mixed && around > 0.0;
    vec4 background = sum_over(summed, 0.5 * vec2(texel), p.a, abs(p.a));
    layer.rgb = mixed ? upsampled_background.rgb
              : background.a > 0.0 ? min(background.rgb / background.a, 65504.0) : layer.rgb;
    if (mixed || background.a > 0.0)
        return;
#endif
    // Half extents in texels; a disc of pixels that are higher than wide is higher by their aspect.
    vec2 extent = abs(p.a) * vec2(1.0, pixel_aspect);
    float narrower = alike ? 4.0 * HALF_VARIANCE_PX2 : 0.0;
    extent = 0.5 * sqrt(max(extent * extent - narrower, 0.0));
    float disc = extent.x;
    int rings = ring_count(disc, SPACING);
    float spacing = disc / (float(rings) + 0.5);
    vec2 size = vec2(last + 1);
    vec2 centre = gl_FragCoord.xy / size;
    vec2 stretch = vec2(1.0, extent.y / disc) / size;
    vec4 sum = vec4(p.rgb, 1.0);
    int i = 0;
    for (int ring = 1; ring <= rings; ++ring) {
        float away = ring_radius(ring, spacing);
        if (alike)
            for (int k = 0; k < 8 * ring; ++k, ++i)
                sum += vec4(textureLod(half_resolution, centre + away * directions[i] * stretch, 0.0).rgb, 1.0);
        else
            for (int k = 0; k < 8 * ring; ++k, ++i) {
                vec4 q = tap(i, away, spacing > SPACING);
                sum += (1.0 - nearer(p.a, q.a)) * vec4(q.rgb, 1.0);
            }
    }
    layer.rgb = min(sum.rgb / sum.a, 65504.0);
}
#endif

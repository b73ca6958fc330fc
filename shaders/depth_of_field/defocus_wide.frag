#version 450 core
// Wide blur at half resolution, one layer at a time: what is behind, or (FRONT) what is in front.
//
// Input:  points, points_half (defocus_half.frag), reach (defocus_reach.frag); signed CoC RADIUS in px.
// Output: back: rgb = mean over the texel's own disc of its surface and those behind it,
//               a = the texel's radius, by which full resolution tells surfaces apart;
//         FRONT: rgb * opacity, opacity of the wide discs of nearer surfaces.
// Discs of more than FAR_PX, if there is such a limit, come from wide_back and wide_front, whose texels are
// of LEVEL px (defocus_far.frag): here their taps would lie far apart. Beside rims they are summed as there
// (points_far, fronts_far).
//
// Half resolution blurs by itself, but not across rims. So where there are none the discs are
// smaller by its variance: a disc of radius 2 px is half resolution itself. The layers:
// depth_of_field.frag.
#include "coc.glsl"
#include "gather.glsl"
#ifdef FAR_PX
#include "wide_layers.glsl"
#include "far.glsl"
#include "far_sum.glsl"
#endif

uniform sampler2D points;
uniform sampler2D points_half;
uniform sampler2D reach;

out vec4 layer;

// Taps lie about this far apart, in texels, until RINGS is reached.
const float SPACING = 1.0;

ivec2 texel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(points_half, 0) - 1;

// Taps near each other read full resolution: half of it would move rims by up to half a pixel.
vec4 tap(int i, float away, bool halved) {
    vec2 at = vec2(texel) + 0.5 + away * directions[i] * vec2(1.0, pixel_aspect);
    ivec2 whole = ivec2(floor(2.0 * at - 0.5));  // texel t is pixel 2 t
    return halved ? texelFetch(points_half, clamp(ivec2(at), ivec2(0), last), 0)
                  : texelFetch(points, clamp(whole, ivec2(0), textureSize(points, 0) - 1), 0);
}

#ifdef FRONT
void main() {
    float p = texelFetch(points_half, texel, 0).a;
    vec4 tile = texelFetch(reach, 2 * texel / TILE, 0);
    bool has_front = tile.a < p - margin_px(p);
    float front_px = has_front ? max(-tile.a, p) : 0.0;
    layer = vec4(0.0);
#ifdef FAR_PX
    bool far = max(abs(p), front_px) > FAR_PX;
    float around = mix_layers(texel, p, far, true, abs(p) > FAR_PX);
    bool mixed = far && suffices(around), summed = far && !mixed && around > 0.0;
    layer = mixed ? mixed_front : sum_over(summed && has_front, 0.5 * vec2(texel), p, front_px);
    if (mixed || summed)
        return;
#endif
    if (!has_front)
        return;
    float disc = 0.5 * front_px;
    int rings = ring_count(disc, SPACING);
    float spacing = disc / (float(rings) + 0.5);
    float area = 0.25 * PI * spacing * spacing;
    int i = 0;
    for (int ring = 1; ring <= rings; ++ring) {
        float away = ring_radius(ring, spacing);
        for (int k = 0; k < 8 * ring; ++k, ++i) {
            vec4 q = tap(i, away, spacing > SPACING);
            float is_front = nearer(p, q.a);
            if (is_front <= 0.0 || abs(q.a) <= SMALL_PX)
                continue;
            float over = is_front * front_opacity(away, 0.5 * abs(q.a), spacing, area);
            layer += over * vec4(q.rgb, 1.0);
        }
    }
}
#else
void main() {
    vec4 p = texelFetch(points_half, texel, 0);
    layer = p;
    vec4 tile = texelFetch(reach, 2 * texel / TILE, 0);
    bool alike = is_alike(p.a, tile, 1.5);
    if (abs(p.a) <= SMALL_PX)
        return;
#ifdef FAR_PX
    bool far = abs(p.a) > FAR_PX;
    float around = mix_layers(texel, p.a, far, false, true);
    bool mixed = far && suffices(around), summed = far && !mixed && around > 0.0;
    vec4 back = sum_over(summed, 0.5 * vec2(texel), p.a, abs(p.a));
    layer.rgb = mixed ? mixed_back.rgb : back.a > 0.0 ? min(back.rgb / back.a, 65504.0) : layer.rgb;
    if (mixed || back.a > 0.0)
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
                sum += vec4(textureLod(points_half, centre + away * directions[i] * stretch, 0.0).rgb, 1.0);
        else
            for (int k = 0; k < 8 * ring; ++k, ++i) {
                vec4 q = tap(i, away, spacing > SPACING);
                sum += (1.0 - nearer(p.a, q.a)) * vec4(q.rgb, 1.0);
            }
    }
    layer.rgb = min(sum.rgb / sum.a, 65504.0);
}
#endif

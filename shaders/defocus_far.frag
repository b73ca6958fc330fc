#version 450 core
// Very wide blur, one layer at a time, from every texel of LEVEL px that a disc covers: what is behind, or
// (FRONT) what is in front.
//
// Input:  points_far (defocus_half.frag, again and again), reach (defocus_reach.frag); FRONT: fronts_far
//         (defocus_fronts.frag). With FAR_PX: wide_back, wide_front, drawn as here on texels twice as wide.
//         Signed CoC RADIUS in px of image width, negative in front of the focus.
// Output: as defocus_wide.frag.
//
// A ring of few taps would make a ring of dots of a lamp. These discs are the grid's (disc_share): no tap
// lies between them, the sum over a disc is its light.
#include "coc.glsl"
#include "gather.glsl"
#include "far.glsl"
#ifdef FAR_PX
#include "wide_layers.glsl"
#endif

uniform sampler2D points_far;

out vec4 layer;

ivec2 texel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(points_far, 0) - 1;
vec4 p = texelFetch(points_far, texel, 0);

#ifdef FRONT
uniform sampler2D fronts_far;
uniform sampler2D reach;

vec4 light_of(ivec2 there, float away) {
    vec4 q = texelFetch(fronts_far, there, 0);
    vec2 front = unpacked_front(q.a);
    float over = front.y * nearer(p.a, front.x);
    return over * disc_share(away, grid_radius_px(disc_texels(abs(front.x)))) * vec4(q.rgb, 1.0);
}
#else
float own_grid = grid_radius_px(disc_texels(abs(p.a)));

vec4 light_of(ivec2 there, float away) {
    vec4 q = texelFetch(points_far, there, 0);
    return (1.0 - nearer(p.a, q.a)) * disc_share(away, own_grid) * vec4(q.rgb, 1.0);
}
#endif

// What comes from all texels within a disc of this radius (px).
vec4 sum_over(float radius_px) {
    vec4 sum = vec4(0.0);
    float most = grid_radius_px(disc_texels(radius_px)) + 0.5 * RIM_PX;
    int rows = int(most * pixel_aspect);
    for (int y = -rows; y <= rows; ++y) {
        float row = float(y) / pixel_aspect;
        int cells = cells_of(row, most);
        for (int x = -cells; x <= cells; ++x)
            sum += light_of(clamp(texel + ivec2(x, y), ivec2(0), last), sqrt(float(x * x) + row * row));
    }
    return sum;
}

#ifdef FRONT
void main() {
    vec4 tile = texelFetch(reach, LEVEL * texel / TILE, 0);
    bool has_front = tile.a < p.a - margin_px(p.a);
    float own_px = abs(p.a), front_px = has_front ? max(-tile.a, p.a) : 0.0;
    layer = vec4(0.0);
#ifdef FAR_PX
    if (mix_layers(texel, p.a, max(own_px, front_px) > FAR_PX, true, least_around(own_px, front_px))) {
        layer = mixed_front;
        return;
    }
#endif
    if (has_front)
        layer = sum_over(front_px) / (PI * pixel_aspect);
}
#else
void main() {
    layer = p;
    float radius_px = abs(p.a);
    if (radius_px <= SMALL_PX)
        return;
#ifdef FAR_PX
    if (mix_layers(texel, p.a, radius_px > FAR_PX, false, BEHIND)) {
        layer.rgb = mixed_back.rgb;
        return;
    }
#endif
    vec4 sum = sum_over(radius_px);
    layer.rgb = min(sum.rgb / sum.a, 65504.0);
}
#endif

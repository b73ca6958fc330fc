#version 450 core
// Small discs of one surface: the mean of reads that cover a pixel's own disc, each texel once.
//
// Input:  colour (linear HDR); depth, focus (include/coc_of_depth.glsl), whose RADIUS is in px of image
//         width. pairs: PAIRS of opposite reads, outwards: x and y (px) of one from the middle of the
//         disc's pixel, how far that is, and by which part of it a read moves inwards where none of it
//         is inside the rim. WIDTH_PX: of what is read: a texel, or with BLOCKS 2 x 2, bilinearly.
//         WIDEST_PX: radius that they cover; wider discs spread them.
// Output: rgb, linear HDR.
//
// The rim of a disc falls over the width of what is read. 2 x 2 texels that it leaves a part of are
// read nearer to the disc's middle, so that the inner ones weigh more. Twin:
// tests/oracles/disc_footprint.py.
#include "coc.glsl"
#include "coc_of_depth.glsl"

uniform sampler2D colour;
uniform vec4 pairs[PAIRS];
uniform int pair_count;      // PAIRS, which compilers must not know: unrolled loops do not end early
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

float radius;    // of the disc that is covered, px
float spread;    // of the reads, for wider discs
vec4 sum = vec4(0.0);  // rgb * weight, weight

#ifdef BLOCKS
vec2 uv, per_px;  // of the pixel's middle; texture coordinates per px

vec3 read_at(vec2 away) {
    return textureLod(colour, uv + away * per_px, 0.0).rgb;
}
#else
ivec2 pixel, last;

vec3 read_at(vec2 away) {
    return texelFetch(colour, clamp(pixel + ivec2(away), ivec2(0), last), 0).rgb;
}
#endif

void add(vec4 pair, vec2 square) {
    float weight = disc_weight(length(pair.xy * square), radius, WIDTH_PX);
#ifdef BLOCKS
    vec2 away = spread * (1.0 - pair.w * (1.0 - weight)) * pair.xy;
    weight *= 4.0;
#else
    vec2 away = pair.xy;
#endif
    sum += weight * vec4(read_at(away) + read_at(-away), 2.0);
}

void main() {
    ivec2 own = ivec2(gl_FragCoord.xy);
    radius = abs(radius_of(own));
#ifdef BLOCKS
    spread = max(radius / WIDEST_PX, 1.0);
    radius /= spread;
    per_px = 1.0 / vec2(textureSize(colour, 0));
    uv = gl_FragCoord.xy * per_px;
#else
    pixel = own;
    last = textureSize(colour, 0) - 1;
#endif
    radius -= NARROWER_PX;
    float reach_px = (radius + 0.5 * WIDTH_PX) * max(pixel_aspect, 1.0);
    vec2 square = vec2(1.0, 1.0 / pixel_aspect);
    sum = disc_weight(0.0, radius, WIDTH_PX) * vec4(texelFetch(colour, own, 0).rgb, 1.0);
    for (int i = 0; i < pair_count && pairs[i].z < reach_px; ++i)
        add(pairs[i], square);
    blurred = vec4(min(sum.rgb / sum.a, 65504.0), 1.0);
}

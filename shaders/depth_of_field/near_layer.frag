#version 450 core
// A coarser level of what is near, two surfaces in a texel: nothing else is in it.
//
// Input:  FROM_PIXELS: colour_and_coc as `finer` (colour_and_coc.frag); next, next_depth: what is seen behind its
//         near things (near_depth.frag), depth 1 where nothing was drawn; else light and radius of a level as fine again.
// Output: texel t holds texels 2t and 2t + 1 of the input: rgb and coverage, premultiplied by coverage, and
//         signed RADIUS (px of image width), times coverage; of the nearer surface, then of the farther one.
//
// What lies farther may be hidden by the nearer surface, or beside it in the texel.
#include "eyes.glsl"
#include "coc.glsl"
#include "near.glsl"
#ifdef FROM_PIXELS
#include "coc_of_depth.glsl"
#include "finite.glsl"

uniform eye_image finer;
uniform eye_image next;
uniform eye_image next_depth;
#else
uniform eye_image light[2];
uniform eye_image radius;
#endif

layout(location = 0) out vec4 nearer_light;
layout(location = 1) out vec4 farther_light;
layout(location = 2) out vec2 radius_of_both;

vec4 lights[8];  // of each texel the nearer surface, and the farther
float radii[8];  // times coverage

float radius_of(int i) {
    return lights[i].a > 0.0 ? radii[i] / lights[i].a : 0.0;
}

void read(int i, ivec2 at) {
#ifdef FROM_PIXELS
    vec4 pixel = texel_of(finer, at);
    float z = texel_of(next_depth, at).r;
    float behind = radius_at(z, (vec2(at) + 0.5) / vec2(size_of(finer)));
    vec2 part = vec2(near_part(pixel.a), z < 1.0 ? apart(behind) : 0.0);
    lights[2 * i] = part.x * vec4(pixel.rgb, 1.0);
    radii[2 * i] = part.x * pixel.a;
    lights[2 * i + 1] = part.y > 0.0 ? part.y * vec4(finite(texel_of(next, at).rgb), 1.0) : vec4(0.0);
    radii[2 * i + 1] = part.y * behind;
#else
    lights[2 * i] = texel_of(light[0], at);
    lights[2 * i + 1] = texel_of(light[1], at);
    vec2 both = texel_of(radius, at).rg;
    radii[2 * i] = both.x;
    radii[2 * i + 1] = both.y;
#endif
}

bool is_nearer(int k, float between) {
    return k % 2 == 0 && radius_of(k) <= between;
}

// Radius times coverage of what a texel has as one surface. Of two of pixels the larger's: their mean, which is none's,
// would seem to slant to both (near_gather.frag).
float radius_in(vec2 sum, vec2 foremost) {
#ifdef FROM_PIXELS
    vec2 larger = 2.0 * foremost.y >= sum.y ? foremost : sum - foremost;
    return larger.x * sum.y / max(larger.y, 1e-4);
#else
    return sum.x;
#endif
}

void main() {
#ifdef FROM_PIXELS
    ivec2 last = size_of(finer) - 1;
#else
    ivec2 last = size_of(light[0]) - 1;
#endif
    float nearest = 0.0, farthest = -1e4;
    for (int i = 0; i < 4; ++i) {
        read(i, min(2 * ivec2(gl_FragCoord.xy) + ivec2(i & 1, i >> 1), last));
        for (int k = 2 * i; k < 2 * i + 2; ++k) {
            nearest = min(nearest, radius_of(k));
            farthest = lights[k].a > 0.0 ? max(farthest, radius_of(k)) : farthest;
        }
    }
    // Which are one surface, gather as one.
    float between = farthest - nearest > 2.0 * margin_px(nearest) ? 0.5 * (nearest + farthest) : 0.0;
    vec2 foremost = vec2(nearest, 0.0);
    for (int k = 0; k < 8; ++k)
        foremost.y = is_nearer(k, between) ? foremost.y : min(foremost.y, radius_of(k));
    vec4 found[2] = vec4[2](vec4(0.0), vec4(0.0));
    vec2 sums[2] = vec2[2](vec2(0.0), vec2(0.0));          // radius and coverage, of all
    vec2 sums_foremost[2] = vec2[2](vec2(0.0), vec2(0.0)); // and of the foremost surface
    for (int i = 0; i < 4; ++i) {
        vec2 covered = vec2(0.0);
        for (int k = 2 * i; k < 2 * i + 2; ++k) {
            int which = is_nearer(k, between) ? 0 : 1;
            float part = lights[k].a > 0.0 ? 0.25 * min(1.0, max(1.0 - covered[which], 0.0) / lights[k].a) : 0.0;
            covered[which] += lights[k].a;
            found[which] += part * lights[k];
            vec2 sum = part * vec2(radii[k], lights[k].a);
            sums[which] += sum;
            sums_foremost[which] += radius_of(k) - foremost[which] < 2.0 * margin_px(foremost[which]) ? sum : vec2(0.0);
        }
    }
    nearer_light = found[0];
    farther_light = found[1];
    radius_of_both = vec2(radius_in(sums[0], sums_foremost[0]), radius_in(sums[1], sums_foremost[1]));
}

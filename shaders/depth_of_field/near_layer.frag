#version 450 core
// A coarser level of what is near, two surfaces in a texel: nothing else is in it.
//
// Input:  FROM_PIXELS: colour_and_coc as `finer` (colour_and_coc.frag); next, next_depth: what is seen behind its
//         near things (near_depth.frag), depth 1 where nothing was drawn; else light and radius of a level as fine again.
// Output: texel t holds texels 2t and 2t + 1 of the input: rgb and coverage, premultiplied by coverage, and
//         signed RADIUS (px of image width), times coverage; of the nearer surface, then of the farther one.
//
// What lies farther may be hidden by the nearer surface, or beside it in the texel. A pixel on a silhouette has light of
// what is next behind, which is drawn: it is taken out, and the pixel covered as far as the near surface does.
#include "eyes.glsl"
#include "coc.glsl"
#include "near.glsl"
#include "where.glsl"
#ifdef FROM_PIXELS
#include "coc_of_depth.glsl"
#include "coverage.glsl"
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
    vec3 beside = finite(texel_of(next, at).rgb);
    float less = z < 1.0 ? (1.0 - coverage_of(pixel.a)) * (1.0 - lamp_part(vec4(beside, 0.0))) : 0.0;
    lights[2 * i] = part.x * vec4(max(pixel.rgb - less * beside, 0.0), 1.0 - less);
    radii[2 * i] = part.x * (1.0 - less) * pixel.a;
    lights[2 * i + 1] = part.y * vec4(beside, 1.0);
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

// Of two surfaces, each what is added up.
struct Sum {
    vec4 light;
    vec2 all;       // radius and coverage
    vec2 foremost;  // and of the foremost surface
};

Sum added(Sum sum, bool wanted, int k, float part, float foremost) {
    vec2 both = wanted ? part * vec2(radii[k], lights[k].a) : vec2(0.0);
    bool is_foremost = radius_of(k) - foremost < 2.0 * margin_px(foremost);
    return Sum(sum.light + (wanted ? part * lights[k] : vec4(0.0)), sum.all + both,
               sum.foremost + (is_foremost ? both : vec2(0.0)));
}

void gather_surfaces() {
    float nearest = 0.0, farthest = -1e4;
    for (int k = 0; k < 8; ++k) {
        nearest = min(nearest, radius_of(k));
        farthest = lights[k].a > 0.0 ? max(farthest, radius_of(k)) : farthest;
    }
    // Which are one surface, gather as one.
    float between = farthest - nearest > 2.0 * margin_px(nearest) ? 0.5 * (nearest + farthest) : 0.0;
    float foremost = 0.0;
    for (int k = 0; k < 8; ++k)
        foremost = is_nearer(k, between) ? foremost : min(foremost, radius_of(k));
    Sum front = Sum(vec4(0.0), vec2(0.0), vec2(0.0)), back = front;
    for (int i = 0; i < 4; ++i) {
        vec2 covered = vec2(0.0);
        for (int k = 2 * i; k < 2 * i + 2; ++k) {
            bool is_front = is_nearer(k, between);
            float free = max(1.0 - (is_front ? covered.x : covered.y), 0.0);
            float part = lights[k].a > 0.0 ? 0.25 * min(1.0, free / lights[k].a) : 0.0;
            covered += lights[k].a * (is_front ? vec2(1.0, 0.0) : vec2(0.0, 1.0));
            front = added(front, is_front, k, part, nearest);
            back = added(back, !is_front, k, part, foremost);
        }
    }
    nearer_light = front.light;
    farther_light = back.light;
    radius_of_both = vec2(radius_in(front.all, front.foremost), radius_in(back.all, back.foremost));
}

void main() {
#ifdef FROM_PIXELS
    ivec2 last = size_of(finer) - 1;
#else
    ivec2 last = size_of(light[0]) - 1;
#endif
    nearer_light = farther_light = vec4(0.0);
    radius_of_both = vec2(0.0);
    float most = 0.0;
    for (int i = 0; i < 4; ++i) {
        read(i, min(2 * ivec2(gl_FragCoord.xy) + ivec2(i & 1, i >> 1), last));
        most = max(most, max(lights[2 * i].a, lights[2 * i + 1].a));
    }
    WHERE (most > 0.0) {
        gather_surfaces();
    }
}

#version 450 core
// The discs of near things at half resolution, but small ones of what is seen (near_pixels.frag), and who hides whom
// among them.
//
// Input:  light: NEAR_LEVELS levels of what is near; light_2: of what is near behind that, or beside it in the
//         texel; radius: of both (near_layer.frag); tile (near_tiles.frag).
//         EACH_NEAR_LEVEL(f): f(1) f(2) … of them (include/levels.glsl).
// Output: rgb and opacity, premultiplied, about the middles of texels of level 1.
//
// Where p is near, its surface is the mean over p's own disc of what is neither nearer nor well behind it: within a
// surface that is exactly 1. What is nearer scatters over it, and over a p that is not near: a q adds 1 / area(q).
// Below it is the mean of the surface behind, and what else lies well behind. What a nearer surface hides in the
// image is cut off where that surface hides it from the lens's point, too: a lamp is no veil.
// Every texel of a disc counts once, on its level (include/levels.glsl).
#include "eyes.glsl"
#include "coc.glsl"
#include "discs.glsl"
#include "finite.glsl"
#include "levels.glsl"
#include "near.glsl"

flat in vec4 tile;

uniform eye_image light[NEAR_LEVELS];   // of level 1, 2, …
uniform eye_image light_2[NEAR_LEVELS];
uniform eye_image radius[NEAR_LEVELS];  // of both

out vec4 over_all;

ivec2 middle = ivec2(gl_FragCoord.xy);
ivec2 last_texel = size_of(light[0]) - 1;
vec4 p = texel_of(light[0], middle);
vec4 p_behind = texel_of(light_2[0], middle);
float own_radius = p.a > 0.0 ? texel_of(radius[0], middle).r / p.a : 0.0;
float radius_behind = p_behind.a > 0.0 ? texel_of(radius[0], middle).g / p_behind.a : 0.0;

// A lamp is no veil: of it, what is hidden from the lens's point is missing; of other surfaces it goes on.
float lamp_behind = lamp_part(p_behind);

vec4 own = vec4(0.0);          // of p's surface
vec4 behind = vec4(0.0);       // of the surface behind it

// Light and opacity without what is left to pixels, and opacity with it: that hides what is behind as well.
struct Over {
    vec4 light;
    float opacity;
};

Over nearer_only = Over(vec4(0.0), 0.0);   // of what is nearer than p
Over farther_only = Over(vec4(0.0), 0.0);  // of what is farther
Over all = Over(vec4(0.0), 0.0), all_behind = Over(vec4(0.0), 0.0);  // of all that is near
float own_behind = 0.0;        // of p's surface, what is the surface behind it, which goes on from it

// How the radius of p's surface grows, per pixel.
float step_to(ivec2 to) {
    ivec2 at = clamp(middle + to, ivec2(0), last_texel);
    float part = texel_of(light[0], at).a;
    return part > 0.0 ? 0.5 * (texel_of(radius[0], at).r / part - own_radius) : 1e4;
}

vec2 slope = vec2(lesser(step_to(ivec2(1, 0)), -step_to(ivec2(-1, 0))),
                  lesser(step_to(ivec2(0, 1)), -step_to(ivec2(0, -1))));

// Part of a disc that is drawn on a level: the first has those of pixels, too.
float part_on(int level, float radius_px) {
    return level > 1 ? level_part(level, radius_px) : 1.0 - coarser_part(1, radius_px);
}

float texels_of(float radius_px, float texel_px) {
    return grid_radius_px(disc_texels(sqrt(max(radius_px * radius_px - ENLARGED_PX2, 0.0)), texel_px));
}

// Of a light's disc. Where it is brighter than white, its rim shows from where it begins, not from where it is half:
// so much narrower, it is white as far as it should be.
float texels_of_light(vec4 light, float radius_px, float texel_px) {
    float texels = texels_of(radius_px, texel_px);
    float white = max(max(light.r, light.g), light.b) / (PI * texels * texels);
    return texels - 0.5 * RIM_PX * max(0.5 - inversesqrt(6.0 * max(white, 1e-3)), 0.0);
}

// Part of a place that is covered by what is nearer: between texels of the finest level, whose silhouettes are
// not cut to texels of a disc's own level.
float nearer_part(vec2 at, float than_px) {
    vec2 place = at - 0.5;
    ivec2 first = ivec2(floor(place));
    vec2 beside = place - vec2(first);
    float found = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1), texel = clamp(first + step, ivec2(0), last_texel);
        vec2 share = mix(1.0 - beside, beside, vec2(step));
        float part = texel_of(light[0], texel).a;
        float q_px = part > 0.0 ? texel_of(radius[0], texel).r / part : 0.0;
        found += share.x * share.y * part * nearer(than_px, q_px);
    }
    return found;
}

// Part of a texel's second surface that lies beside its first, and not behind it.
float visible(vec4 first, vec4 second) {
    return min(1.0 - first.a, second.a) / max(second.a, 1e-4);
}

// Whether a level draws a disc that p wants.
float own_part_on(int level, vec4 of, float radius_px) {
    return of.a > 0.0 ? part_on(level, -radius_px) : 0.0;
}

void add(inout Over sum, float part, float kept, vec4 comes) {
    part /= PI * pixel_aspect;
    sum.light += part * kept * comes;
    sum.opacity += part * comes.a;
}

void gather(eye_image light_of, eye_image light_2_of, eye_image radius_of, int level) {
    float texel_px = float(1 << level);
    float own_part = own_part_on(level, p, own_radius), behind_part = own_part_on(level, p_behind, radius_behind);
    float widest = level < LEVELS - 1 ? min(tile.r, widest_on(level)) : tile.r;
    bool comes = level == 1 ? tile.g < widest_on(1) || LEVELS == 2 : coarser_part(level - 1, tile.r) > 0.0;
    comes = comes && (level == LEVELS - 1 || tile.g < widest_on(level));
    float own_texels = texels_of_light(p, -own_radius, texel_px);
    float behind_texels = texels_of_light(p_behind, -radius_behind, texel_px);
    float most = max(max(own_part > 0.0 ? own_texels : 0.0, behind_part > 0.0 ? behind_texels : 0.0),
                     comes ? texels_of(widest, texel_px) : 0.0);
    float reach = most + 0.5 * RIM_PX;
    vec2 place = 2.0 * gl_FragCoord.xy / texel_px - 0.5;
    float rows = reach * pixel_aspect;
    int top = comes || own_part + behind_part > 0.0 ? int(floor(place.y + rows)) : -1000000;
    ivec2 last = size_of(light_of) - 1;
    vec4 found = vec4(0.0), found_behind = vec4(0.0);
    float seen = 0.0, seen_behind = 0.0, found_both = 0.0;
    for (int y = int(ceil(place.y - rows)); y <= top; ++y) {
        float row = (float(y) - place.y) / pixel_aspect;
        float cells = sqrt(max(reach * reach - row * row, 0.0));
        int right = int(floor(place.x + cells));
        for (int x = int(ceil(place.x - cells)); x <= right; ++x) {
            ivec2 at = clamp(ivec2(x, y), ivec2(0), last);
            vec4 q = texel_of(light_of, at);
            bool outside = at != ivec2(x, y);
            float known = outside ? 1.0 - lamp_part(q) : 1.0;  // the image's border goes on, but no lamp
            vec2 off = vec2(float(x), float(y)) - place;
            float away = length(vec2(off.x, row));
            float share = disc_share(away, own_texels), share_behind = disc_share(away, behind_texels);
            seen += share;
            seen_behind += share_behind;
            if (known * q.a > 0.0) {
                float q_px = texel_of(radius_of, at).r / q.a;
                q *= known;
                float own_px = clamp(own_radius + texel_px * dot(slope, off), 2.0 * own_radius, 0.25 * own_radius);
                float is_nearer = nearer(own_px, q_px), is_farther = farther(own_px, q_px);
                // Of what q hides: far behind it, what is known; close behind it goes on as beside it.
                float far_before = is_nearer * farther(q_px, own_px);
                float beside = nearer(radius_behind, q_px), far_beside = beside * farther(q_px, radius_behind);
                vec4 comes_here = apart(q_px) * part_on(level, -q_px) * disc_share(away, texels_of_light(q, -q_px, texel_px)) * q;
                float kept = 1.0 - pixels_part(q_px);
                add(all, 1.0, kept, comes_here);
                add(nearer_only, is_nearer, kept, comes_here);
                float last_px = p_behind.a > 0.0 ? radius_behind : own_px;
                add(farther_only, farther(last_px, q_px), kept, comes_here);
                vec4 as_own = (1.0 - is_nearer - is_farther) * share * q;
                float as_behind = 1.0 - beside - farther(radius_behind, q_px);
                found += as_own;
                found_both += as_behind * as_own.a;
                found_behind += as_behind * share_behind * q;
                vec4 q2 = texel_of(light_2_of, at);
                float hidden = (is_nearer - far_before) * q.a, hidden_behind = (beside - far_beside) * q.a;
                if (q2.a > 0.0) {
                    float q2_px = texel_of(radius_of, at).g / q2.a;
                    q2 *= outside ? 1.0 - lamp_part(q2) : 1.0;
                    // Seen from here, the nearer surface hides it elsewhere.
                    vec2 by = gl_FragCoord.xy + 0.5 * texel_px * off * (q_px / q2_px);
                    float hides = nearer_part(by, q2_px), hides_lamp = lamp_behind * hides;
                    float visible_2 = visible(q, q2);
                    vec4 comes_2 = (1.0 - hides) * apart(q2_px) * part_on(level, -q2_px)
                                 * disc_share(away, texels_of_light(q2, -q2_px, texel_px)) * q2;
                    float kept_2 = 1.0 - visible_2 * pixels_part(q2_px);
                    add(all_behind, 1.0, kept_2, comes_2);
                    add(farther_only, farther(last_px, q2_px), kept_2, comes_2);
                    float same = 1.0 - nearer(own_px, q2_px) - farther(own_px, q2_px);
                    vec4 as_own_2 = mix(visible_2, 1.0, far_before) * same * share * q2;
                    found += as_own_2;
                    hidden += far_before * nearer(own_px, q2_px) * q2.a;
                    float beside_2 = nearer(radius_behind, q2_px);
                    float same_2 = 1.0 - beside_2 - farther(radius_behind, q2_px);
                    found_both += same_2 * as_own_2.a;
                    found_behind += mix(visible_2, 1.0 - hides_lamp, far_beside) * same_2 * share_behind * q2;
                    hidden_behind += far_beside * (beside_2 + hides_lamp * same_2) * q2.a;
                }
                seen -= hidden * share;
                seen_behind -= hidden_behind * share_behind;
            }
        }
    }
    own += own_part > 0.0 && seen > 1e-5 ? own_part * found / seen : vec4(0.0);
    own_behind += own_part > 0.0 && seen > 1e-5 ? own_part * found_both / seen : 0.0;
    behind += behind_part > 0.0 && seen_behind > 1e-5 ? behind_part * found_behind / seen_behind : vec4(0.0);
}

// Part of p that is drawn apart, or goes on beside what is: a straight end takes 3 texels of 9.
float part_apart() {
    float found = 3.0 * max(apart(own_radius), apart(radius_behind));
    int around = p.a > 0.0 && found < 3.0 ? 1 : -1;
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            ivec2 at = clamp(middle + ivec2(x, y), ivec2(0), last_texel);
            float q_part = texel_of(light[0], at).a;
            found += q_part > 0.0 ? q_part * apart(texel_of(radius[0], at).r / q_part) : 0.0;
        }
    return min(p.a + p_behind.a, 1.0) * min(found / 3.0, 1.0);
}

// Opacity adds up to 1 at most.
Over limited(Over sum) {
    float most = max(sum.opacity, 1.0);
    return Over(sum.light / most, sum.opacity / most);
}

Over upon(Over front, float part, Over back) {
    return Over(front.light + part * back.light, front.opacity + part * back.opacity);
}

Over upon(Over front, Over back) {
    return upon(front, 1.0 - front.opacity, back);
}

// What is seen past the front, and not through it.
Over past(Over front, Over back) {
    return upon(front, min(1.0, (1.0 - front.opacity) / max(back.opacity, 1e-4)), back);
}

void main() {
#define GATHER(level) gather(light[level - 1], light_2[level - 1], radius[level - 1], level);
    EACH_NEAR_LEVEL(GATHER)
    Over surface = limited(Over((1.0 - pixels_part(own_radius)) * own, own.a));
    Over back = limited(Over((1.0 - visible(p, p_behind) * pixels_part(radius_behind)) * behind, behind.a));
    // Of the surface behind, what is beside p's in the texel may be in both: it counts once.
    float twice = own_behind * min(1.0 - p.a, p_behind.a) / max(p_behind.a, 1e-4);
    Over both = upon(surface, max(1.0 - surface.opacity - twice * (1.0 / max(back.opacity, 1e-4) - 1.0), 0.0), back);
    over_all = min(mix(past(limited(all), all_behind).light, past(upon(limited(nearer_only), both), farther_only).light,
                       part_apart()), HALF_MAX);
}

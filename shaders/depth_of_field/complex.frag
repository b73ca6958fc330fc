#version 450 core
// Depth of field by gathering what other pixels would scatter here, with who hides whom.
//
// Input:  colour_and_coc (colour_and_coc.frag; signed CoC RADIUS in px of image width, negative in front
//         of the focus); layers of level 1, 2 … (layers.frag): what wide discs are made of; tile: what may
//         reach it (coc_tile_dilate.frag). WITH_CUT: near (near_gather.frag), near_pixels (near_pixels.frag), near_light and
//         near_radius (the finest of near_layer.frag), cut (cut_tiles.frag).
// Output: the blurred image, linear HDR, full resolution.
//
// A pixel p looks for three kinds of neighbours q, told apart by their CoC, which orders depth:
//
//   surface     q is p's own surface. A lens sample u sees it at p + u r_p, or past its silhouette
//               something behind: so much of p's OWN disc is covered by it. Where q is p's
//               surface, q's own disc says how much of q lands here, so that lamps keep their light.
//   behind      q is much farther than p: what is seen past the silhouette. Behind the focus its mean is
//               by the discs of each q, which are wider; in front of it, where the lens sees what p
//               hides, by p's own. What is only a little farther may be p's surface that slants.
//   foreground  q is nearer than p. Its disc covers p if it is wide enough: q adds 1 / area(q) to an
//               opacity, and the foreground is composited over the others. A sharp q covers no
//               neighbour, so sharp silhouettes do not bleed; a blurred near q spreads over a sharp p.
//
//        disc of a nearer q       On one slanted surface all kinds give the same answer, so
//           ___                   where the lines between them are drawn does not show. Beside a
//         /     \                 silhouette the part that is left free inside it and the opacity
//     ---|---p---|--- behind      outside add up, and what is behind is the same mean on both sides.
//         \ ___ /                 Surface and behind are normalised (a constant image stays
//                                 constant), the foreground's opacity is absolute and stops at 1.
//
// Every texel of a disc counts once, on the level (include/levels.glsl) on which it has not too many: no
// sample lies between two others, so that lamps make no beads. What is behind is a soft mean and part of a
// pixel: one level coarser does for it where a disc has enough texels there (COARSER_BEHIND). No noise, hence the same
// kernel in both eyes. Carnegie & Rhee 2015, Algorithm 1; gathering after
// Jimenez 2014, "Next generation post processing in Call of Duty: Advanced Warfare".
//
// Renderers on the CPU run both sides of every branch, but no loop that no pixel wants: so what few
// pixels want is a loop.
#include "eyes.glsl"
#include "coc.glsl"
#include "coverage.glsl"
#include "discs.glsl"
#include "levels.glsl"
#include "layers.glsl"
#ifdef WITH_CUT
#include "near.glsl"
#include "near_over.glsl"
#endif

flat in vec4 tile;

uniform eye_image colour_and_coc;
#if LEVELS > 1
uniform ueye_image layers[LEVELS - 1];  // of level 1, 2, …
#endif

out vec4 blurred;

ivec2 pixel = ivec2(gl_FragCoord.xy);
vec4 p = texel_of(colour_and_coc, pixel);
float own_px = abs(p.a);

// 1 where p is in a quadrant of its tile within whose reach a surface ends, else 0: all around is its surface.
ivec2 quadrant = 2 * pixel / POINT_PX & 1;
float near_end = float(int(tile.g) >> (quadrant.x + 2 * quadrant.y) & 1);

vec4 surface = vec4(0.0);     // rgb * part of p's disc, part
vec4 behind = vec4(0.0);      // rgb * weight, weight
vec4 foreground = vec4(0.0);  // rgb * opacity, opacity

#ifdef WITH_CUT
// A lamp is no veil. What is near is drawn over this image and veils it evenly: of a lamp's disc there is so much
// more here, or less, that what is seen of it is cut where something near hides it from the lens's point.
uniform eye_image near;
uniform eye_image near_pixels;
uniform eye_image near_light;
uniform eye_image near_radius;
uniform eye_image cut;

const float STEEPER = 3.0;      // so many pixels are two texels, from the middle of one to that of the next but one
const float LEAST_FREE = 0.02;  // where near things leave less, no lamp shines through by this

float free_of_near = 1.0 - near_over(near, near_pixels, pixel).a;
float widest_near_px = -texel_of(cut, pixel / POINT_PX).r;

// Of something near about a place, in texels of the finest level: its RADIUS, or `none`.
float near_radius_at(vec2 at, float none) {
    ivec2 texel = clamp(ivec2(floor(at)), ivec2(0), size_of(near_light) - 1);
    float part = texel_of(near_light, texel).a;
    return part > 0.25 ? texel_of(near_radius, texel).r / part : none;
}

// How often the light of a disc `off` px away is to be here.
float lit(vec4 q, vec2 off) {
    float lamp = q.a > 0.5 ? lamp_part(q) : 0.0;
    vec2 here = 0.5 * gl_FragCoord.xy, lens = 0.5 * off / max(q.a, 0.5);
    lamp = free_of_near < 1.0 ? lamp : 0.0;
    float near_px = 0.0, covered = 0.0, most = 0.0;
    vec2 place = vec2(0.0);
    // Few pixels want it. First the radius, then four texels.
    for (int i = 0; i < (lamp > 0.0 ? 5 : 0); ++i)
        if (i == 0) {
            near_px = min(near_radius_at(here, 0.0), near_radius_at(here + 0.5 * off, 0.0));
            near_px = near_px < 0.0 ? near_px : near_radius_at(here + widest_near_px * lens, widest_near_px);
            place = here + near_px * lens - 0.5;
        } else {
            ivec2 step = ivec2(i - 1 & 1, i - 1 >> 1), last = size_of(near_light) - 1;
            vec2 beside = fract(place), share = mix(1.0 - beside, beside, vec2(step));
            float part = texel_of(near_light, clamp(ivec2(floor(place)) + step, ivec2(0), last)).a;
            covered += share.x * share.y * part;
            most = max(most, part);
        }
    // Between texels a silhouette is a ramp, along which a lamp would still be white: in the image one of about a pixel.
    float steeper = max(STEEPER / (1.0 - near_px / max(q.a, 0.5)), 1.0);
    covered = most * clamp(steeper * (covered / max(most, 1e-4) - 0.5) + 0.5, 0.0, 1.0);
    return mix(1.0, (1.0 - min(covered, 1.0)) / max(free_of_near, LEAST_FREE), lamp * apart(near_px));
}
#else
float lit(vec4 q, vec2 off) {
    return 1.0;
}
#endif

// How many texels to either side a row has within reach.
float cells_of(float row, float reach) {
    return sqrt(max(reach * reach - row * row, 0.0));
}

// How much farther than p, in radius, and in parts of p's own, what is behind begins half and ends one and a half times.
const float FARTHER_PX = 0.25;   // Fitted: python -m bench --only fitted
const float FARTHER_PART = 0.2;  // Fitted: python -m bench --only fitted

// 0 where q may be the surface of p or is nearer, 1 where it is behind.
float farther(float q) {
    return near_end * clamp((q - p.a) / (FARTHER_PART * own_px + FARTHER_PX) - 0.5, 0.0, 1.0);
}

// 0 where q may be the surface of p or is behind it, 1 where it is nearer.
float nearer_than_p(float q) {
    return near_end * nearer(p.a, q);
}

// In front of the focus, from where on what p hides is seen within p's own disc rather than by the discs of what is
// behind. Where near things are drawn apart, p's disc is narrower.
const float WIDE_NEAR_PX = 2.0;

// The radius of a disc behind p (px).
float radius_behind(float q) {
    return mix(max(abs(q), own_px), own_px, clamp(-p.a - WIDE_NEAR_PX, 0.0, 1.0));
}

float behind_px = 0.0;  // the widest disc of what is seen past p's silhouette, 0 if nothing is

// Takes down that q is seen past p's silhouette.
void note_behind(float q, float weight) {
    behind_px = weight > 0.0 ? max(behind_px, radius_behind(q)) : behind_px;
}

// 1 for what is no wider than that.
float is_seen(float q) {
    return clamp((behind_px - radius_behind(q)) / margin_px(behind_px) + 2.0, 0.0, 1.0);
}

// What `found` of p's surface covers of p's disc, of which behind it `free` is left.
void add_surface(float own, vec4 found, float free) {
    float all = found.a + free;
    // p's surface may be too small for a level.
    surface += own > 0.0 ? own * (all > 1e-4 ? found / all : vec4(p.rgb, 1.0)) : vec4(0.0);
}

// Of a pixel at a silhouette the light is both surfaces': less what is seen beside the nearer one, as sharp as it is there.
vec4 without(vec4 sum, float less, vec4 beside) {
    return less > 0.0 ? max(sum - less * vec4(beside.rgb / beside.a, 1.0), vec4(0.0)) : sum;
}

// In focus, p is its own surface where it covers the pixel, and past it what is behind shows.
void gather_in_focus(float less) {
    vec4 beside = vec4(0.0);
    ivec2 last = size_of(colour_and_coc) - 1;
    int around = less > 0.0 ? 1 : -1;
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 q = texel_of(colour_and_coc, clamp(pixel + ivec2(x, y), ivec2(0), last));
            float shows = coverage_of(q.a) < 1.0 ? 0.0 : farther(q.a) * (1.0 - lamp_part(q));
            note_behind(q.a, shows);
            beside += shows * vec4(q.rgb, 1.0);
        }
    surface = without(vec4(p.rgb, 1.0), beside.a > 0.0 ? less : 0.0, beside);
}

// All pixels around: the surface where `own`, and, unless it is left out, the foreground that is drawn on pixels.
void gather_pixels(float own, float foreground_px, bool with_foreground) {
    float slack_px = slack_of(own_px);
    float widest_px = max(own > 0.0 ? own_px + slack_px : 0.0, foreground_px);
    float reach = widest_px > 0.0 ? grid_radius_px(widest_px) + 0.5 * RIM_PX : -1.0;
    int rows = int(floor(reach * pixel_aspect));
    ivec2 last = size_of(colour_and_coc) - 1;
    vec4 found = vec4(0.0), over = vec4(0.0), beside = vec4(0.0);
    float free = 0.0, found_less = 0.0, over_less = 0.0;
    for (int y = -rows; y <= rows; ++y) {
        float row = float(y) / pixel_aspect;
        int cells = int(cells_of(row, reach));
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texel_of(colour_and_coc, clamp(pixel + ivec2(x, y), ivec2(0), last));
            q.rgb *= lit(q, vec2(x, y));
            float away = sqrt(float(x * x) + row * row);
            float radius = abs(q.a);
            float is_nearer = nearer_than_p(q.a), is_farther = farther(q.a);
            float as_own = clamp(radius, own_px - slack_px, own_px + slack_px);
            float share = disc_share(away, grid_radius_px(mix(as_own, radius, is_nearer)));
            float as_found = (1.0 - is_nearer - is_farther) * share, less = 1.0 - coverage_of(q.a);
            found += as_found * vec4(q.rgb, 1.0);
            free += is_farther * share;
            found_less += as_found * less;
            note_behind(q.a, is_farther * share);
            float shows = less > 0.0 ? 0.0 : 1.0 - lamp_part(q);
            beside += shows * (own > 0.0 ? is_farther : 1.0 - is_nearer) * share * vec4(q.rgb, 1.0);
            if (with_foreground) {
                float comes = (radius > 0.5 ? is_nearer * (1.0 - coarser_part(0, radius)) : 0.0) * share;
                over += comes * vec4(q.rgb, 1.0);
                over_less += comes * less;
            }
        }
    }
    found_less = own > 0.0 && beside.a > 0.0 ? found_less : 0.0;
    add_surface(own, without(found, found_less, beside), free + found_less);
    foreground += without(over, beside.a > 0.0 ? over_less : 0.0, beside) / (PI * pixel_aspect);
}

// All pixels around: what is behind and drawn on pixels.
void gather_pixels_behind(float widest_px) {
    float reach = widest_px > 0.0 ? grid_radius_px(widest_px) + 0.5 * RIM_PX : -1.0;
    int rows = int(floor(reach * pixel_aspect));
    ivec2 last = size_of(colour_and_coc) - 1;
    for (int y = -rows; y <= rows; ++y) {
        float row = float(y) / pixel_aspect;
        int cells = int(cells_of(row, reach));
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texel_of(colour_and_coc, clamp(pixel + ivec2(x, y), ivec2(0), last));
            q.rgb *= lit(q, vec2(x, y));
            float radius = radius_behind(q.a);
            behind += farther(q.a) * is_seen(q.a) * (1.0 - coarser_part(0, radius))
                    * disc_share(sqrt(float(x * x) + row * row), grid_radius_px(radius)) * vec4(q.rgb, 1.0);
        }
    }
}

// The texels of a level of which a disc so wide takes something: columns are those of each row.
struct Rows {
    vec2 place;
    float reach;
    int first;
    int last;
};

Rows rows_within(float texel_px, float texels) {
    float reach = texels > 0.0 ? texels + 0.5 * RIM_PX : -1.0;
    vec2 place = gl_FragCoord.xy / texel_px - 0.5;
    float rows = reach * pixel_aspect;
    return Rows(place, reach, int(ceil(place.y - rows)), reach > 0.0 ? int(floor(place.y + rows)) : -1000000);
}

const float HALF_DIAGONAL = 0.7072;  // of a texel

// All texels of a level around: the surface where `own`, and, unless left out, the foreground drawn there.
void gather_texels(ueye_image layers, int level, float own, float foreground_px, bool with_foreground) {
    float texel_px = float(1 << level);
    float own_texels = grid_radius_px(disc_texels(own_px, texel_px));
    float front_texels = grid_radius_px(disc_texels(foreground_px, texel_px));
    Rows rows = rows_within(texel_px, max(own > 0.0 ? own_texels : 0.0,
                                          foreground_px > 0.0 ? front_texels : 0.0));
    ivec2 last = size_of(layers) - 1;
    vec4 found = vec4(0.0), over = vec4(0.0);
    float free = 0.0;
    for (int y = rows.first; y <= rows.last; ++y) {
        float row = (float(y) - rows.place.y) / pixel_aspect;
        float cells = cells_of(row, rows.reach);
        int right = int(floor(rows.place.x + cells));
        for (int x = int(ceil(rows.place.x - cells)); x <= right; ++x) {
            Layers q = unpack_layers(texel_of(layers, clamp(ivec2(x, y), ivec2(0), last)));
            vec2 off = texel_px * (vec2(x, y) - rows.place);
            q.front.rgb *= lit(q.front, off);
            q.back.rgb *= lit(q.back, off);
            float away = length(vec2(float(x) - rows.place.x, row));
            float share = disc_share(away, own_texels);
            float front = q.coverage, back = 1.0 - q.coverage;
            float front_nearer = nearer_than_p(q.front.a), back_nearer = nearer_than_p(q.back.a);
            float front_farther = farther(q.front.a), back_farther = farther(q.back.a);
            // A texel at the rim comes farther than the reach within which no surface ends.
            bool is_rim = (away + HALF_DIAGONAL) * texel_px > own_px;
            float front_own = 1.0 - front_farther - (is_rim ? nearer(p.a, q.front.a) : front_nearer);
            float back_own = 1.0 - back_farther - (is_rim ? nearer(p.a, q.back.a) : back_nearer);
            found += share * (front * front_own * vec4(q.front.rgb, 1.0) + back * back_own * vec4(q.back.rgb, 1.0));
            free += share * (front * front_farther + back * back_farther);
            note_behind(q.front.a, own > 0.0 ? share * front * front_farther : 0.0);
            note_behind(q.back.a, own > 0.0 ? share * back * back_farther : 0.0);
            if (with_foreground) {
                float front_px = abs(q.front.a), back_px = abs(q.back.a);
                over += front_nearer * front * level_part(level, front_px)
                      * disc_share(away, grid_radius_px(disc_texels(front_px, texel_px))) * vec4(q.front.rgb, 1.0);
                over += back_nearer * back * level_part(level, back_px)
                      * disc_share(away, grid_radius_px(disc_texels(back_px, texel_px))) * vec4(q.back.rgb, 1.0);
            }
        }
    }
    add_surface(own, found, free);
    foreground += over / (PI * pixel_aspect);
}

// What a texel adds of one surface that is behind, of the discs that are `for_level`.
vec4 part_behind(int level, int for_level, float away, vec4 q, float coverage) {
    float radius = radius_behind(q.a);
    return farther(q.a) * is_seen(q.a) * coverage * level_part(for_level, radius)
         * disc_share(away, grid_radius_px(disc_texels(radius, float(1 << level)))) * vec4(q.rgb, 1.0);
}

// All texels of a level around: what is behind, of the discs that are `for_level`.
void gather_texels_behind(ueye_image layers, int level, int for_level, float widest_px) {
    float texel_px = float(1 << level);
    Rows rows = rows_within(texel_px, widest_px > 0.0 ? grid_radius_px(disc_texels(widest_px, texel_px)) : 0.0);
    ivec2 last = size_of(layers) - 1;
    for (int y = rows.first; y <= rows.last; ++y) {
        float row = (float(y) - rows.place.y) / pixel_aspect;
        float cells = cells_of(row, rows.reach);
        int right = int(floor(rows.place.x + cells));
        for (int x = int(ceil(rows.place.x - cells)); x <= right; ++x) {
            Layers q = unpack_layers(texel_of(layers, clamp(ivec2(x, y), ivec2(0), last)));
            vec2 off = texel_px * (vec2(x, y) - rows.place);
            q.front.rgb *= lit(q.front, off);
            q.back.rgb *= lit(q.back, off);
            float away = length(vec2(float(x) - rows.place.x, row));
            behind += part_behind(level, for_level, away, q.front, q.coverage)
                    + part_behind(level, for_level, away, q.back, 1.0 - q.coverage);
        }
    }
}

float widest_of(int level) {
    return level < LEVELS - 1 ? widest_on(level) : 1e4;
}

// The widest foreground disc of a level that may come here, 0 for none.
float foreground_of(int level) {
    bool there = near_end > 0.0 && tile.r < p.a - margin_px(p.a) && (int(tile.b) & (1 << level)) != 0;
    return there ? min(max(-tile.r, p.a), widest_of(level)) : 0.0;
}

const float NEARLY_ALL = 0.999;  // of a disc: what is behind the rest shows by less than a step of 8 bits

// The widest disc of a level of what is behind, 0 for none.
float behind_of(int level) {
    float widest_px = behind_px + 2.0 * margin_px(behind_px);
    bool wanted = surface.a < NEARLY_ALL && behind_px > 0.0;
    bool there = coarser_part(level, own_px) < 1.0 && (level == 0 || coarser_part(level - 1, widest_px) > 0.0);
    return wanted && there ? min(widest_px, widest_of(level)) : 0.0;
}

float own_part(int level) {
    return own_px > 0.5 ? level_part(level, own_px) : 0.0;
}

// A level in one of two loops: where nothing nearer may cover p, one that does not ask for it.
void gather_level_0() {
    float own = own_part(0), foreground_px = foreground_of(0);
    gather_pixels(foreground_px > 0.0 ? 0.0 : own, 0.0, false);
    gather_pixels(foreground_px > 0.0 ? own : 0.0, foreground_px, true);
}

void gather_level(ueye_image layers, int level) {
    float own = own_part(level), foreground_px = foreground_of(level);
    gather_texels(layers, level, foreground_px > 0.0 ? 0.0 : own, 0.0, false);
    gather_texels(layers, level, foreground_px > 0.0 ? own : 0.0, foreground_px, true);
}

void main() {
    if (own_px <= 0.5)
        gather_in_focus(near_end * (1.0 - coverage_of(p.a)));
    gather_level_0();
#define GATHER(level) gather_level(layers[level - 1], level);
    EACH_COARSER_LEVEL(GATHER)
    gather_pixels_behind(behind_of(0));
// What is behind is summed one level coarser, if there is one.
#define SUMMED_ON(level) min(level + COARSER_BEHIND, LEVELS - 1)
#define GATHER_BEHIND(level) gather_texels_behind(layers[SUMMED_ON(level) - 1], SUMMED_ON(level), level, behind_of(level));
    EACH_COARSER_LEVEL(GATHER_BEHIND)
    vec3 own = behind.a > 1e-5 ? surface.rgb + (1.0 - surface.a) * behind.rgb / behind.a
                               : surface.rgb / max(surface.a, 1e-5);
    vec3 over = foreground.a > 0.0 ? foreground.rgb / foreground.a : vec3(0.0);
    vec3 all = mix(own, over, min(foreground.a, 1.0));
    blurred = vec4(own_px <= 0.5 && surface.a >= 1.0 && foreground.a <= 0.0 ? p.rgb : min(all, HALF_MAX), 1.0);
}

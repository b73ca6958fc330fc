#version 450 core
// Motion blur by gathering along streaks, with who hides whom: tiles of class COMPLEX.
//
// Input:  colour (linear HDR, filtered), velocity (half_velocity.glsl), depth (reverse-Z, 0 = sky),
//         longest and crossing, by tile (tile_max_dilate.frag).
// Output: the image as a shutter would see it, open around the frame's own time; full resolution.
// Half velocities are RADII, px: a point spreads from -u to +u around where it is drawn.
//
// The one-dimensional sister of composite.frag. A pixel p has
//
//   a background  the average of p's own surface and what is behind it, along p's OWN streak;
//   a foreground  nearer points q whose streak is long enough to sweep over p. Each adds its share
//                 of the time, step / (2 |u_q|), to an opacity; it goes over the background.
//
// Foregrounds are looked for along the longest streak around and, where another one crosses it, along
// that as well: an object that goes up before a faster background that goes sideways sweeps over no pixel
// beside it. Where one of them is p's own streak as well, one walk serves both. What does not move
// does not bleed: its streak reaches no other pixel.
//
//          ^            A foreground q has the half velocity u. By how far u lies along and beside the
//          |            two lines, one share of its opacity counts in the walk along the first
//    <---- p ----> 1    line, the rest in the walk along the second (share_along). The shares
//          |            make 1, so that no foreground counts twice; one that goes along a line counts
//       ___v___         there, in full.
//      | q  ^ u|
//      |____|__|  2
//
// Limits: one velocity for each pixel, so what is seen through holes or hidden by p stays unknown,
// paths are straight, and highlights go with the surface, though they stay where the light is.
// Two directions for each tile: a foreground that goes a third way is found as far as it lies along
// these, and one that goes within 12 degrees of the longest streak is taken to go along it. Fronts
// that sweep over p at the same time add up, whichever hides the other. Where p is on the foreground
// itself, the background beside its silhouette edge is blurred along the foreground's streak, not along its own.
// No noise, so the same scene point blurs alike in both eyes; samples grow with the streak instead.
// McGuire et al. 2012, "A reconstruction filter for plausible motion blur"; p's own direction and
// the neighbourhood's as in Guertin et al. 2013, "A fast and stable feature-aware motion blur
// filter"; the crossing one and the shares are ours. NumPy twin: tests/oracles/motion.py, share_along.
#include "eyes.glsl"
#include "velocity.glsl"
#include "half_velocity.glsl"
#include "motion_tile_classes.glsl"

uniform eye_image colour;
uniform eye_image depth;
uniform eye_image longest;
uniform eye_image crossing;
out vec4 blurred;

ivec2 pixel = ivec2(gl_FragCoord.xy);
ivec2 last = size_of(velocity) - 1;

// xy = half velocity, z = depth.
vec3 point_at(ivec2 at) {
    return vec3(half_velocity_at(at), texel_of(depth, at).r);
}

vec3 p = point_at(pixel);

vec4 background = vec4(0.0);   // rgb * weight, weight
vec4 foreground = vec4(0.0);  // rgb * opacity, opacity; of all walks

// 0 where q is p's surface, behind it, or moves along with it; 1 where it is nearer by 4 % or more
// and goes its own way. What moves together uncovers nothing: a plain average is exact there.
const float NEARER_PART = 0.02;  // above the rounding of depths; errors hardly depend on it

float in_front(vec3 q) {
    float nearer = clamp((q.z - p.z * (1.0 + NEARER_PART)) / (p.z * NEARER_PART + 1e-8), 0.0, 1.0);
    return nearer * clamp(length(q.xy - p.xy) / tolerance_px(length(p.xy)) - 1.0, 0.0, 1.0);
}

// Taps to both sides of p on a streak through it, in pixels along the longer axis of the image.
// Each stands for `stride` pixels, of which it asks the middle one where it goes. STRIDE is 1 or 3: of
// three pixels the light is read at two places, 2/3 px from the middle, so that the filter weighs
// all three alike. One read would leave pixels out, and every edge would come out as a comb.
struct Walk {
    vec2 step;         // px of the image for one px along the longer axis
    float per_square;  // 1 / (its length squared)
    float reach;       // of p's own half velocity, along the longer axis; 0 in other directions
    float end;         // how far to look, along the longer axis
    int stride;
    bool whole_pixels;
};

struct Tap {
    float first;  // pixel that it stands for, px from p
    float along;  // where it lies, px from p
    float time;   // that p's streak is over it, in px of its way
};

float longer_axis(vec2 v) {
    return max(abs(v.x), abs(v.y));
}

Walk walk_along(vec2 line, float end, bool is_own, int stride, bool whole_pixels) {
    float reach = longer_axis(line);
    vec2 step = line / reach;
    return Walk(step, 1.0 / dot(step, step), is_own ? reach : 0.0, end, stride, whole_pixels);
}

int taps(Walk walk) {
    return (int(ceil(walk.end)) + walk.stride - 1) / walk.stride;
}

Tap tap_of(Walk walk, int j) {
    float first = float((j - 1) * walk.stride + 1), other = first + float(walk.stride - 1);
    float a = time_over(first, walk.reach), b = time_over(other, walk.reach);
    float along = mix(first, other, b / max(a + b, 1e-6));
    return Tap(first, along, 0.5 * float(walk.stride) * (a + b));
}

vec3 read(vec2 at, bool whole_pixels) {
    vec2 where = whole_pixels ? floor(at) + 0.5 : at;
    return filtered_at(colour, where / vec2(last + 1)).rgb;
}

vec4 colour_at(vec2 at, Walk walk) {
#if STRIDE == 3
    vec2 apart = (walk.stride > 1 ? 2.0 / 9.0 * float(walk.stride) : 0.0) * walk.step;
    vec3 both = read(at - apart, walk.whole_pixels) + read(at + apart, walk.whole_pixels);
    return vec4(0.5 * both, 1.0);
#else
    return vec4(read(at, walk.whole_pixels), 1.0);
#endif
}

const float CLOSER_PX = 0.01;  // decides between two pixels at one distance

// other: the line of the other walk for the foreground; 0 where there is one only.
void gather_at(vec2 offset, Walk walk, Tap tap, bool for_background, bool for_foreground, vec2 other) {
    vec2 at = vec2(pixel) + 0.5 + offset;
    // Between two pixels, the closer one.
    ivec2 pixel_there = ivec2(floor(at - offset * (CLOSER_PX / tap.along)));
    vec3 q = point_at(clamp(pixel_there, ivec2(0), last));
    float is_foreground = in_front(q);
    // p's own surface and what is behind it.
    float shown = for_background ? (1.0 - is_foreground) * tap.time : 0.0;
    // What sweeps over p: q does for the part of the time that its own streak is over p.
    float sweep = abs(dot(q.xy, walk.step)) * walk.per_square;
    float time = clamp(sweep + 0.5 - tap.first, 0.0, float(walk.stride));
    float opacity = is_foreground * time / max(2.0 * sweep, 1e-3);
    float over = for_foreground ? opacity * share_along(q.xy, walk.step, other) : 0.0;
    if (shown + over > 0.0) {
        vec4 c = colour_at(at, walk);
        background += shown * c;
        foreground += over * c;
    }
}

void gather(Walk walk, bool for_background, bool for_foreground, vec2 other) {
    int j = 0, last_tap = taps(walk);
    do {
        Tap tap = tap_of(walk, ++j);
        gather_at(-tap.along * walk.step, walk, tap, for_background, for_foreground, other);
        gather_at(tap.along * walk.step, walk, tap, for_background, for_foreground, other);
    } while (j < last_tap);
}

// Steepness, in parts of the longest streak, from which taps take whole pixels.
const float WHOLE_FROM = 0.75;  // errors hardly depend on it

// Whether what goes along a line is found along p's own streak as well.
bool goes_along(vec2 line) {
    return line != vec2(0.0) && !crosses(line, p.xy);
}

void main() {
    vec4 tile = texel_of(longest, pixel / TILE);
    vec2 around = tile.xy, across = texel_of(crossing, pixel / TILE).xy;
    float reach = length(around);
    bool moves = length(p.xy) >= LEAST_PX;
    // Where sharp and moving objects meet, a filtered tap would carry half a sharp pixel along.
    bool whole_pixels = tile.w > WHOLE_FROM * reach;
    // Odd, so that there is a middle.
    int stride = max(whole_pixels ? 1 : STRIDE, int(ceil(reach / float(MOST_TAPS))) | 1);
    blurred = texel_of(colour, pixel);
    background = (moves ? time_over(0.0, longer_axis(p.xy)) : 1.0) * vec4(blurred.rgb, 1.0);
    bool is_first = moves && goes_along(around);
    bool is_second = moves && !is_first && goes_along(across);
    if (moves) {
        float end = max(longer_axis(p.xy), longer_axis(is_first ? around : is_second ? across : p.xy));
        Walk own = walk_along(p.xy, end, true, stride, whole_pixels);
        gather(own, true, is_first || is_second, is_second ? around : across);
    }
    // The lines that are not p's own. As `do`, it goes through once where there is one.
    vec2 line = is_first ? across : around, other = is_first ? p.xy : is_second ? p.xy : across;
    bool both = !is_first && !is_second && across != vec2(0.0), again;
    do {
        if (line != vec2(0.0))
            gather(walk_along(line, longer_axis(line), false, stride, whole_pixels), false, true, other);
        line = across;
        other = around;
        again = both;
        both = false;
    } while (again);
    if (foreground.a <= 0.0 && !moves)
        return;
    vec3 over = foreground.a > 0.0 ? foreground.rgb / foreground.a : vec3(0.0);
    blurred.rgb = min(mix(background.rgb / background.a, over, min(foreground.a, 1.0)), HALF_MAX);
}

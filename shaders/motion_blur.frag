#version 450 core
// Motion blur by gathering along streaks, with who hides whom.
//
// Input:  colour (linear HDR, filtered), streaks (streaks.frag), longest (streak_neighbours.frag).
// Output: the image as a shutter would see it, open around the frame's own time; full resolution.
// Half streaks are RADII, px: a point spreads from -u to +u around where it is drawn.
//
// The one-dimensional sister of depth_of_field.frag. A pixel p has
//
//   a back   the average of p's own surface and what is behind it, along p's OWN streak;
//   a front  nearer points q whose streak is long enough to sweep over p. Each adds its share of
//            the time, step / (2 |u_q|), to an opacity; the front goes over the back.
//
// Fronts are looked for along the longest streak around. Where that is p's own streak as well,
// one walk serves both. What does not move does not bleed: its streak reaches no other pixel.
// Most tiles need none of that: where the streaks change slowly from pixel to pixel, all taps move
// along with p, nothing is uncovered, and a plain average along p's streak is the same to the bit.
// No noise, so the same scene point blurs alike in both eyes; samples grow with the streak instead.
// McGuire et al. 2012, "A reconstruction filter for plausible motion blur"; two directions as in
// Guertin et al. 2013, "A fast and stable feature-aware motion blur filter".
uniform sampler2D colour;
uniform sampler2D streaks;
uniform sampler2D longest;
uniform float samples_per_px;  // of a whole streak

out vec4 blurred;

const float LEAST_PX = 0.25;  // half streaks below this are left alone: half a pixel in all

ivec2 pixel = ivec2(gl_FragCoord.xy);
ivec2 last = textureSize(streaks, 0) - 1;
vec4 p = texelFetch(streaks, pixel, 0);

vec4 back = vec4(0.0);   // rgb * weight, weight
vec4 front = vec4(0.0);  // rgb * opacity, opacity

// By how much another streak may differ from p's and still count as moving along with it.
float tolerance_px = 0.25 + 0.1 * length(p.xy);

// 0 where q is p's surface, behind it, or moves along with it; 1 where it is nearer by 4 % or more
// and goes its own way. What moves together uncovers nothing: a plain average is exact there.
float in_front(vec4 q) {
    float nearer = clamp((q.z - p.z * 1.02) / (p.z * 0.02 + 1e-5), 0.0, 1.0);
    return nearer * clamp(length(q.xy - p.xy) / tolerance_px - 1.0, 0.0, 1.0);
}

// Where taps lie on a streak through p. Where sharp and moving things meet, a filtered tap would
// carry half a sharp pixel along: there, taps are whole pixels, twice as many.
struct Walk {
    int pairs;  // taps to each side; the middle one is p itself
    float spacing;
    vec2 direction;
    bool whole_pixels;
};

Walk walk_along(vec2 half_streak, bool whole_pixels) {
    float reach = length(half_streak);
    int pairs = int(ceil(reach * samples_per_px * (whole_pixels ? 2.0 : 1.0)));
    return Walk(pairs, 2.0 * reach / float(2 * pairs + 1), half_streak / reach, whole_pixels);
}

vec2 place(Walk walk, int i) {
    return vec2(pixel) + 0.5 + (float(i) * walk.spacing) * walk.direction;
}

vec3 colour_at(vec2 at, bool whole_pixels) {
    vec2 where = whole_pixels ? floor(at) + 0.5 : at;
    return textureLod(colour, where / vec2(last + 1), 0.0).rgb;
}

vec4 streak_at(vec2 at) {
    return texelFetch(streaks, clamp(ivec2(floor(at)), ivec2(0), last), 0);
}

// Nothing in front anywhere near: the average along p's streak.
void gather_plain(Walk walk) {
    for (int i = -walk.pairs; i <= walk.pairs; ++i)
        back += vec4(colour_at(place(walk, i), walk.whole_pixels), 1.0);
}

// p's own surface and what is behind it; what is in front is left out.
void gather_back(Walk walk) {
    for (int i = -walk.pairs; i <= walk.pairs; ++i) {
        vec2 at = place(walk, i);
        back += (1.0 - in_front(streak_at(at))) * vec4(colour_at(at, walk.whole_pixels), 1.0);
    }
}

// What sweeps over p: q does if it moves this way far enough; its rim is one spacing soft.
void gather_front(Walk walk) {
    for (int i = -walk.pairs; i <= walk.pairs; ++i) {
        vec2 at = place(walk, i);
        vec4 q = streak_at(at);
        float sweep = abs(dot(q.xy, walk.direction));
        float covers = clamp((sweep - abs(float(i)) * walk.spacing) / walk.spacing + 0.5, 0.0, 1.0);
        float share = in_front(q) * covers * min(walk.spacing / max(2.0 * sweep, 1e-3), 1.0);
        if (share > 0.0)
            front += share * vec4(colour_at(at, walk.whole_pixels), 1.0);
    }
}

void main() {
    vec4 tile = texelFetch(longest, pixel / TILE, 0);
    vec2 around = tile.xy;
    float reach = length(around);
    blurred = texelFetch(colour, pixel, 0);
    if (reach < LEAST_PX)
        return;
    bool moves = length(p.xy) >= LEAST_PX;
    // Between p and the farthest tap lie at most sqrt(2) * reach + 2 steps from pixel to pixel.
    bool smooth_motion = tile.w * (1.4143 * reach + 2.0) <= tolerance_px;
    if (smooth_motion && !moves)
        return;
    bool whole_pixels = tile.z < 0.25 * reach;
    Walk own = walk_along(p.xy, whole_pixels);
    if (smooth_motion) {
        gather_plain(own);
    } else {
        if (moves)
            gather_back(own);
        else
            back = vec4(blurred.rgb, 1.0);
        float apart = min(length(around - p.xy), length(around + p.xy));  // a streak has two ends
        bool together = moves && apart < 0.25 + 0.05 * reach;
        gather_front(together ? own : walk_along(around, whole_pixels));
        if (front.a <= 0.0 && !moves)
            return;
    }
    vec3 over = front.a > 0.0 ? front.rgb / front.a : vec3(0.0);
    blurred.rgb = min(mix(back.rgb / back.a, over, min(front.a, 1.0)), 65504.0);
}

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

// 0 where q is p's surface or behind it, 1 where it is nearer by 4 % or more.
float nearer(float depth) {
    return clamp((depth - p.z * 1.02) / (p.z * 0.02 + 1e-5), 0.0, 1.0);
}

// Where sharp and moving things meet, a filtered tap would carry half a sharp pixel along: there,
// taps are whole pixels, twice as many.
void gather(vec2 half_streak, bool for_back, bool for_front, bool whole_pixels) {
    float reach = length(half_streak);
    // An odd number, so that the middle one is p itself.
    int pairs = int(ceil(reach * samples_per_px * (whole_pixels ? 2.0 : 1.0)));
    float spacing = 2.0 * reach / float(2 * pairs + 1);
    vec2 direction = half_streak / reach;
    vec2 centre = vec2(pixel) + 0.5;
    vec2 texel = 1.0 / vec2(last + 1);
    for (int i = -pairs; i <= pairs; ++i) {
        float along = float(i) * spacing;
        vec2 at = centre + along * direction;
        vec4 q = texelFetch(streaks, clamp(ivec2(floor(at)), ivec2(0), last), 0);
        if (whole_pixels) at = floor(at) + 0.5;
        vec3 c = texture(colour, at * texel).rgb;
        float is_front = nearer(q.z);
        if (for_back)
            back += (1.0 - is_front) * vec4(c, 1.0);
        // q sweeps over p if it moves this way far enough; its rim is one spacing soft.
        float sweep = abs(dot(q.xy, direction));
        float covers = clamp((sweep - abs(along)) / spacing + 0.5, 0.0, 1.0);
        if (for_front && i != 0)
            front += is_front * covers * min(spacing / max(2.0 * sweep, 1e-3), 1.0) * vec4(c, 1.0);
    }
}

void main() {
    vec3 tile = texelFetch(longest, pixel / TILE, 0).xyz;
    vec2 around = tile.xy;
    blurred = texelFetch(colour, pixel, 0);
    if (dot(around, around) < LEAST_PX * LEAST_PX)
        return;
    bool moves = dot(p.xy, p.xy) >= LEAST_PX * LEAST_PX;
    float apart = min(length(around - p.xy), length(around + p.xy));  // a streak has two ends
    bool together = moves && apart < 0.25 + 0.05 * length(around);
    bool whole_pixels = tile.z < 0.25 * length(around);
    if (moves)
        gather(p.xy, true, together, whole_pixels);
    else
        back = vec4(blurred.rgb, 1.0);
    if (!together)
        gather(around, false, true, whole_pixels);
    if (front.a <= 0.0 && !moves)
        return;
    vec3 over = front.a > 0.0 ? front.rgb / front.a : vec3(0.0);
    blurred.rgb = min(mix(back.rgb / back.a, over, min(front.a, 1.0)), 65504.0);
}

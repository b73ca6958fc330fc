#version 450 core
// All texels in each texel's disc and, where discs from farther away reach it, those in theirs. Drawn where depth
// discontinuities are within reach; elsewhere half_mean.frag.
//
// Input:  surfaces (half_surfaces.frag; signed CoC RADIUS, px of image width, negative in front of the
//         focus), each half as large as the one before; tile (half_tile_dilate.frag).
//         LEVELS: how many; EACH_LEVEL(f): f(0) f(1) …, since software rasterisers read the textures of a
//         loop more slowly; FILL_PX: how far from a texel in focus its surroundings are.
// Output: complete texels: rgb = light of the texel's own disc under what is nearer and spreads over it; a =
//         opacity of that. Where a pixel is sharp, only what covers it: rgb = that times its opacity; a = -1 - opacity.
//
// What is as far as the texel or farther counts as seen in its own disc; nearer things cover it as far as
// their discs come, 1 / area each. Discs are summed on the level on which they have up to 25 texels; what is
// before the focus on those of its own discs, so that a lamp beside a wider disc stays as wide as it is.
// What a near thing hides is what is seen beside it: of the finest level that has it, and no finer than its own
// disc; lamps hardly count, which would shine through.
// In the composite a pixel that is less blurred than its texel shows only `a` of this: there the light is
// that of what covers it. In front of the focus a texel covers itself, as far as nothing behind it is
// seen. What is in focus hardly counts, and covers nothing: where a texel is in focus, its light is that
// of its blurred surroundings, for reads between texels. Texels are read one by one: a mean of two radii
// would be a surface that is not there.
#include "eyes.glsl"
#include "coc.glsl"
#include "discs.glsl"
#include "finite.glsl"
#include "half_coverage.glsl"
#include "half_levels.glsl"

flat in vec4 tile;  // of half_tile_dilate.frag
uniform eye_image surfaces[LEVELS];

const float BEYOND_OWN = 1.25;     // by which what reaches the tile is wider than the pixel's own disc
const float BESIDE_SMALL = 0.7;    // pixels read between texels: one beside a wide disc may be narrower

out vec4 gathered;

const float LEAST = 0.001;    // weight of what is in focus
const float COARSER = 0.125;  // weight of what is seen beside a near thing, by level
const float LEAST_CALM = 1e-6;
const float LEAST_FAR = 0.25, FAR = 0.75;  // difference of radii, in those of the near thing

vec4 p = texel_of(surfaces[0], ivec2(gl_FragCoord.xy));
float front_px = max(-p.a, 0.0);
vec4 seen = LEAST * vec4(p.rgb, 1.0);
vec4 over = vec4(0.0);
vec2 free = vec2(0.0);    // of the texel's own disc: where what is behind it is seen, all
float far = 0.0;          // of that disc: where what it hides is seen
vec4 behind = vec4(0.0);  // that

// Sides of the focus on which nearer things cover the texel.
const int BEHIND = 1, IN_FRONT = 2;

// Whether the texel, in front of the focus, hides it: beside that a slanted surface goes on.
float far_behind(float radius) {
    return p.a < -0.5 ? smoothstep(LEAST_FAR, FAR, (p.a - radius) / p.a) : 0.0;
}

// What lies within a disc, on a level; `beyond`: only what covers the texel.
void gather(eye_image image, int level, float disc_px, float part, bool beyond, int sides) {
    float texel_px = float(2 << level);
    float grid = grid_radius_px(disc_texels(beyond ? disc_px : narrowed_px(disc_px, texel_px), texel_px));
    float reach = grid + 0.5 * RIM_PX, rows = reach * pixel_aspect;
    vec2 place = 2.0 * gl_FragCoord.xy / texel_px - 0.5;
    int top = part > 0.0 ? int(floor(place.y + rows)) : -1000000;
    ivec2 last = size_of(image) - 1;
    for (int y = int(ceil(place.y - rows)); y <= top; ++y) {
        float row = (float(y) - place.y) / pixel_aspect;
        float cells = sqrt(max(reach * reach - row * row, 0.0));
        int right = int(floor(place.x + cells));
        for (int x = int(ceil(place.x - cells)); x <= right; ++x) {
            vec4 q = texel_of(image, clamp(ivec2(x, y), ivec2(0), last));
            float away = length(vec2(float(x) - place.x, row)), radius = abs(q.a);
            float is_nearer = nearer(p.a, q.a), covered = coverage_of(q.a);
            float weight = beyond ? 0.0 : part * disc_share(away, grid);
            float counts = covered * mix(LEAST, 1.0, max(clamp(radius - 0.25, 0.0, 1.0), nearer(q.a, p.a)));
            float is_far = far_behind(q.a);
            far += weight * (1.0 - covered * (1.0 - is_far));
            seen += (1.0 - is_nearer) * (1.0 - is_far) * counts * weight * vec4(q.rgb, 1.0);
            free += weight * vec2(1.0 - covered * (1.0 - nearer(q.a, p.a)), 1.0);
            bool covers = radius > 0.5 && (sides & (q.a < 0.0 ? IN_FRONT : BEHIND)) != 0;
            float of_level = beyond ? half_level_part(level, radius) : part;
            over += covers ? covered * of_level * is_nearer / (PI * pixel_aspect)
                           * disc_share(away, grid_radius_px(disc_texels(radius, texel_px))) * vec4(q.rgb, 1.0)
                           : vec4(0.0);
        }
    }
}

void disc(float radius_px, bool wanted, int sides) {
#define GATHER(level) gather(surfaces[level], level, radius_px, wanted ? half_level_part(level, radius_px) : 0.0, false, sides);
    EACH_LEVEL(GATHER)
}

// What is nearer and in front of the focus, each on the levels of its own disc.
void before(eye_image image, int level, float least_px, float widest_px) {
    const float SHARED = 1.5157;  // 2^0.6: from there to its inverse half_level_part takes a disc
    float level_px = exp2(float(level)) / TEXELS_PER_PX;
    float most_px = level < LEVELS - 1 ? min(widest_px, SHARED * level_px) : widest_px;
    bool any = least_px <= most_px && (level == 0 || SHARED * widest_px > level_px);
    gather(image, level, most_px, any ? 1.0 : 0.0, true, IN_FRONT);
}

// What a near thing hides is what is seen beside it. On the coarsest level all of the disc counts: a step would be where
// the only texel that counts gives way to another.
void beside(eye_image image, int level, bool wanted) {
    vec2 place = gl_FragCoord.xy / float(1 << level) - 0.5;
    float reach = level < LEVELS - 1 ? 1.5 : max(1.0 + max(pixel_aspect, 1.0) * front_px / float(2 << level), 1.5);
    ivec2 first = ivec2(ceil(place - reach)), end = ivec2(floor(place + reach));
    ivec2 last = size_of(image) - 1;
    int top = wanted ? end.y : -1000000;
    for (int y = first.y; y <= top; ++y)
        for (int x = first.x; x <= end.x; ++x) {
            vec4 q = texel_of(image, clamp(ivec2(x, y), ivec2(0), last));
            vec2 near = max(reach - abs(vec2(x, y) - place), 0.0);
            near *= near / (reach * reach * reach);  // as much on each level
            float dark = 1.0 / max(max(q.r, q.g), max(q.b, 1.0));
            float wider = log2(max(2.0 * TEXELS_PER_PX * abs(q.a), 1e-3));
            float calm = clamp(1.0 + float(level) - wider, LEAST_CALM, 1.0);
            float counts = far_behind(q.a) * calm * near.x * near.y * pow(COARSER, float(level));
            behind += counts * pow(dark, 4.0) * vec4(dark * q.rgb, 1.0);
        }
}

void main() {
    float own_px = abs(p.a);
    // Slanted surfaces in front of the focus reach a little farther than a texel's own disc.
    bool apart = tile.r > BEYOND_OWN * front_px + 1.0 || tile.r > 0.5 && BEYOND_OWN * tile.b + 1.0 < front_px;
    float beyond_px = apart ? tile.r : 0.0;
    bool blurred = tile.a > 0.0 && tile.g > SMALL_FROM_PX;
    // Small discs are summed from pixels, and not here.
    bool wanted = blurred && (own_px < 1.0 || own_px > BESIDE_SMALL * SMALL_FROM_PX || beyond_px > 0.0);
    disc(own_px < 1.0 ? FILL_PX : own_px, wanted, beyond_px > 0.0 ? BEHIND : BEHIND | IN_FRONT);
#define BEFORE(level) before(surfaces[level], level, tile.b, blurred ? beyond_px : -1.0);
    EACH_LEVEL(BEFORE)
    float opacity = min(over.a, 1.0);
    float wide = smoothstep(SMALL_FROM_PX, SMALL_PX, own_px);
    float shown = wide + opacity - wide * opacity;  // in the composite
    float hides = far / max(free.y, 1e-4);
#define SEEN_BESIDE(level) beside(surfaces[level], level, hides > 0.01);
    EACH_LEVEL(SEEN_BESIDE)
    vec3 own = seen.rgb / seen.a;
    own = behind.a > 0.0 ? mix(own, behind.rgb / behind.a, hides) : own;
    vec3 front = over.a > 0.0 ? over.rgb / over.a : own;
    float alpha = p.a < 0.0 ? max(opacity, wide * (1.0 - free.x / max(free.y, 1e-4))) : opacity;
    bool only_cover = is_small(p.a) && (own_px < SMALL_FROM_PX || p.a > 0.0 && opacity > LEAST);
    gathered = only_cover ? vec4(min(UP * opacity * front, HALF_MAX), -1.0 - opacity)
                          : vec4(min(UP * mix(own, front, shown > 0.0 ? opacity / shown : 0.0), HALF_MAX), alpha);
}

#version 450 core
// Between what bounds the circles of confusion of each tile lie, and whether surfaces end in it.
//
// Input:  depth, focus (include/coc_of_depth.glsl), or FROM_ALPHA: colour_and_coc. TILE: side of a tile in pixels, even. EXACT_PX,
//         LEVELS: include/levels.glsl.
// Output: one texel per tile; signed RADIUS in pixels of image width, negative in front of the focus:
//         r, g = least and greatest within the limit, with peripheral blur, of the tile and of pixels
//         beside it where a surface ends;
//         b = largest |RADIUS| before the limit, for the record;
//         a = bits (levels.glsl): the levels that discs are drawn on, the quadrants in which surfaces end.
//         b grows away from the focus, so that the nearest or the farthest point has the largest;
//         a tile counts as being where its middle is.
// Source: colour_and_coc.frag.
#include "eyes.glsl"
#include "coc.glsl"
#ifdef FROM_ALPHA
uniform eye_image colour_and_coc;
#define IMAGE colour_and_coc
#else
#include "coc_of_depth.glsl"
uniform eye_image depth;
#define IMAGE depth
#endif
#include "levels.glsl"

out vec4 tile_min_max;

const float NO_LIMIT_PX = 1e9;  // wider than any disc

// A surface ends where radii of pixels beside each other differ by so much, and by this part of the wider one.
const float END_PX = 0.35;    // Fitted: python -m bench --only fitted
const float END_PART = 0.06;  // Fitted: python -m bench --only fitted

vec2 size = vec2(size_of(IMAGE));
vec2 depths = vec2(1.0, 0.0);  // farthest, nearest
vec2 radii = vec2(1e4, -1e4);  // least, greatest
int bits = 0;

// Takes down whether a surface ends between pixels beside each other, in a quadrant of the tile.
void compare(vec2 these, vec2 those, int quadrant) {
    vec2 far = max(these, those), step_px = abs(these - those);
    vec2 widest = max(abs(these), abs(those));
    bvec2 apart = greaterThan(step_px, max(vec2(END_PX), END_PART * abs(far)));
    bool ends = (apart.x && widest.x > 0.5) || (apart.y && widest.y > 0.5);
    bits |= ends ? 1 << (LEVEL_BITS + quadrant) : 0;
    // The pixel beyond the tile may be the one whose disc comes far.
    radii = ends ? vec2(min(radii.x, min(min(these.x, these.y), min(those.x, those.y))),
                        max(radii.y, max(max(these.x, these.y), max(those.x, those.y)))) : radii;
}

void main() {
    const int BLOCKS = TILE / 2 + 1;  // one beyond the tile, so that no surface ends between tiles
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    vec2 below[BLOCKS];
    for (int y = 0; y < BLOCKS; ++y) {
        vec2 left;
        for (int x = 0; x < BLOCKS; ++x) {
            vec2 uv = vec2(first + 2 * ivec2(x, y) + 1) / size;
            // Upper left, upper right, lower right, lower left.
#ifdef FROM_ALPHA
            vec4 r = textureGather(colour_and_coc, place_of_eye(uv), 3);
#else
            vec4 z = textureGather(depth, place_of_eye(uv));
            vec2 l = uv - 0.5 / size, u = uv + 0.5 / size;
            vec4 r = vec4(radius_at(z.x, vec2(l.x, u.y)), radius_at(z.y, u),
                          radius_at(z.z, vec2(u.x, l.y)), radius_at(z.w, l));
#endif
            int quadrant = (4 * x < TILE ? 0 : 1) + (4 * y < TILE ? 0 : 2);
            compare(r.xw, r.yz, quadrant);
            compare(r.xy, r.wz, quadrant);
            if (x > 0)
                compare(r.wx, left, quadrant);
            if (y > 0)
                compare(r.wz, below[x], quadrant);
            left = r.zy;
            below[x] = r.xy;
            if (x < BLOCKS - 1 && y < BLOCKS - 1) {
#ifndef FROM_ALPHA
                depths = vec2(min(min(depths.x, min(z.x, z.y)), min(z.z, z.w)),
                              max(max(depths.y, max(z.x, z.y)), max(z.z, z.w)));
#endif
                vec2 range = vec2(min(min(r.x, r.y), min(r.z, r.w)), max(max(r.x, r.y), max(r.z, r.w)));
                radii = vec2(min(radii.x, range.x), max(radii.y, range.y));
                bits |= levels_of(abs(range.x)) | levels_of(abs(range.y));
            }
        }
    }
    float before_limit = 0.0;
#ifndef FROM_ALPHA
    vec2 middle = min(vec2(first) + 0.5 * float(TILE), size - 0.5) / size;
    before_limit = max(abs(radius_within(NO_LIMIT_PX, depths.x, middle)),
                       abs(radius_within(NO_LIMIT_PX, depths.y, middle)));
#endif
    tile_min_max = vec4(radii, before_limit, float(bits));
}

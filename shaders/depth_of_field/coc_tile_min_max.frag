#version 450 core
// Between what bounds the circles of confusion of each tile lie, and whether surfaces end in it.
//
// Input:  depth, focus (include/coc_of_depth.glsl). TILE: side of a tile in pixels, even. EXACT_PX,
//         LEVELS: include/levels.glsl.
// Output: one texel per tile; signed RADIUS in pixels of image width, negative in front of the focus:
//         r, g = least and greatest within the limit, with peripheral blur;
//         b = largest |RADIUS| before the limit, for the record;
//         a = bits: the levels that discs are drawn on, and EDGE.
//         b grows away from the focus, so that the nearest or the farthest point has the largest;
//         a tile counts as being where its middle is.
// Source: colour_and_coc.frag.
#include "coc.glsl"
#include "coc_of_depth.glsl"
#include "levels.glsl"

out vec4 tile_min_max;

const float NO_LIMIT_PX = 1e9;

vec2 size = vec2(textureSize(depth, 0));
vec2 depths = vec2(1.0, 0.0);     // farthest, nearest
vec2 radii = vec2(1e4, -1e4);     // least, greatest
int bits = 0;

// Whether a surface ends between two radii, the nearer one first.
bool ends(float near, float far) {
    return far - near > margin_px(far) && max(abs(near), abs(far)) > 0.5;
}

// Takes the 2 x 2 pixels around a corner between pixels into account: radii of the left and the lower two.
void add(vec2 corner) {
    vec4 z = textureGather(depth, corner / size);
    vec2 range = vec2(min(min(z.x, z.y), min(z.z, z.w)), max(max(z.x, z.y), max(z.z, z.w)));
    depths = vec2(min(depths.x, range.x), max(depths.y, range.y));
    vec2 found = vec2(radius_at(range.y, corner / size), radius_at(range.x, corner / size));
    radii = vec2(min(radii.x, found.x), max(radii.y, found.y));
    bits |= levels_of(abs(found.x)) | levels_of(abs(found.y)) | (ends(found.x, found.y) ? EDGE : 0);
}

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    // One pixel beyond the tile, so that no surface ends between two tiles.
    ivec2 last = min(first + TILE, ivec2(size) - 1);
    for (int y = first.y; y < max(last.y, first.y + 1); ++y)
        for (int x = first.x; x < max(last.x, first.x + 1); ++x)
            add(vec2(x + 1, y + 1));
    vec2 middle = 0.5 * vec2(first + last + 1) / size;
    tile_min_max = vec4(radii,
                        max(abs(radius_within(NO_LIMIT_PX, depths.x, middle)),
                            abs(radius_within(NO_LIMIT_PX, depths.y, middle))),
                        float(bits));
}

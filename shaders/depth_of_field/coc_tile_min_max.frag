#version 450 core
// Between what bounds the circles of confusion of each tile lie.
//
// Input:  depth, focus (include/coc_of_depth.glsl). TILE: side of a tile in pixels, even.
// Output: one texel per tile; signed RADIUS in pixels of image width, negative in front of the focus:
//         r, g = least and greatest within the limit, with peripheral blur;
//         b = largest |RADIUS| before the limit, for the record.
//         It grows away from the focus, so that the nearest or the farthest point has the largest;
//         for b, a tile counts as being where its middle is.
// Source: colour_and_coc.frag.
#include "coc.glsl"
#include "coc_of_depth.glsl"

out vec4 tile_min_max;

const float NO_LIMIT_PX = 1e9;

// Least and greatest reverse-Z depth of the pixels from `first` to `last`.
vec2 depth_range(ivec2 first, ivec2 last, vec2 size) {
    float nearest = 0.0, farthest = 1.0;
    for (int y = first.y; y <= last.y; y += 2)
        for (int x = first.x; x <= last.x; x += 2) {
            vec4 z = textureGather(depth, vec2(x + 1, y + 1) / size);  // 2 x 2 texels
            nearest = max(nearest, max(max(z.x, z.y), max(z.z, z.w)));
            farthest = min(farthest, min(min(z.x, z.y), min(z.z, z.w)));
        }
    return vec2(farthest, nearest);
}

void main() {
    vec2 size = vec2(textureSize(depth, 0));
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    ivec2 last = min(first + TILE, ivec2(size)) - 1;
    vec2 z = depth_range(first, last, size);
    tile_min_max = vec4(radius_limit_px, -radius_limit_px, 0.0, 0.0);
    for (int i = 0; i < 4; ++i) {
        vec2 corner = vec2(i & 1, i >> 1) * vec2(last + 1 - first) + vec2(first);
        tile_min_max.r = min(tile_min_max.r, radius_at(z.y, corner / size));
        tile_min_max.g = max(tile_min_max.g, radius_at(z.x, corner / size));
    }
#ifdef ALONG_RAY
    // The nearest point of a plane may be inside the tile.
    vec2 nearest = clamp(nearest_uv(z.y), vec2(first) / size, vec2(last + 1) / size);
    tile_min_max.r = min(tile_min_max.r, radius_at(z.y, nearest));
#endif
    vec2 middle = 0.5 * vec2(first + last + 1) / size;
    tile_min_max.b = max(abs(radius_within(NO_LIMIT_PX, z.x, middle)),
                  abs(radius_within(NO_LIMIT_PX, z.y, middle)));
}

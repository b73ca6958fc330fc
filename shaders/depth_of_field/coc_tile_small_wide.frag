#version 450 core
// What each tile has of small discs and of wide ones.
//
// Input:  tile_min_max (coc_tile_min_max.frag); depth, focus (include/coc_of_depth.glsl). TILE:
//         side of a tile (px).
// Output: r = least and g = greatest signed RADIUS in the tile (px of image width, negative in front
//         of the focus); b = greatest RADIUS that is small (above half a pixel, within SMALL_PX), or
//         0: those need every pixel; a = least signed RADIUS of those that are wider, or 1e4.
//
// Only where the range leaves it open, pixels are looked at one by one.
#include "coc.glsl"
#include "coc_of_depth.glsl"

uniform sampler2D tile_min_max;

out vec4 tile;

// Points are half floats: what is within their rounding of SMALL_PX counts as both.
const float ROUNDING = 1.001;

// The last two of the output, of one radius.
vec2 sorted(float radius) {
    float size = abs(radius);
    return vec2(size > 0.5 && size <= SMALL_PX * ROUNDING ? size : 0.0,
                size * ROUNDING > SMALL_PX ? radius : 1e4);
}

void main() {
    ivec2 size = textureSize(depth, 0);
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    vec2 range = texelFetch(tile_min_max, ivec2(gl_FragCoord.xy), 0).rg;
    float widest = max(-range.r, range.g), least = max(range.r, -range.g);
    vec2 found = least > SMALL_PX ? vec2(0.0, range.r) : vec2(widest > 0.5 ? widest : 0.0, 1e4);
    bool open_ = widest * ROUNDING > SMALL_PX && least <= SMALL_PX * ROUNDING;
    found = open_ ? vec2(0.0, 1e4) : found;
    for (int i = 0; i < (open_ ? TILE * TILE : 0); ++i) {
        ivec2 pixel = min(first + ivec2(i % TILE, i / TILE), size - 1);
        float z = texelFetch(depth, pixel, 0).r;
        vec2 one = sorted(radius_at(z, (vec2(pixel) + 0.5) / vec2(size)));
        found = vec2(max(found.x, one.x), min(found.y, one.y));
    }
    tile = vec4(range, found);
}

#version 450 core
// What is blurred how far in each tile, and whether surfaces end in it, from half an image.
//
// Input:  surfaces (half_surfaces.frag). TILE: side of a tile in its texels. WIDE_PX: RADIUS of what is wide.
// Output: r, g = least and greatest signed RADIUS (px of image width), and of texels beside it where a surface
//         ends; b = the greatest in front of the focus, -1e4 for none; a = HAS_SMALL, HAS_END, HAS_WIDE_END
//         (tile_classes.glsl).
#include "eyes.glsl"
#include "half_coverage.glsl"
#include "tile_classes.glsl"

uniform eye_image surfaces;

// A surface ends where radii of texels beside each other differ by so much, and by this part of the wider one.
const float END_PX = 0.5;
const float END_PART = 0.1;

out vec4 range;

bool ends_between(float here, float there) {
    float widest_px = max(abs(here), abs(there));
    return widest_px > 0.5 && abs(here - there) > max(END_PX, END_PART * widest_px);
}

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    ivec2 last = size_of(surfaces) - 1;
    bool small = false, ends = false;
    float below[TILE + 1];
    range = vec4(1e4, -1e4, -1e4, 0.0);
    for (int y = 0; y <= TILE; ++y) {
        float left;
        for (int x = 0; x <= TILE; ++x) {
            float radius = texel_of(surfaces, min(first + ivec2(x, y), last)).a;
            bool inside = x < TILE && y < TILE;
            // One texel beyond the tile, so that no surface ends between tiles.
            bool across = x > 0 && y < TILE && ends_between(radius, left);
            bool along = y > 0 && x < TILE && ends_between(radius, below[x]);
            ends = ends || across || along || coverage_of(radius) < 1.0;
            range.rg = inside || across || along ? vec2(min(range.r, radius), max(range.g, radius)) : range.rg;
            range.b = inside && radius < -0.5 ? max(range.b, radius) : range.b;
            small = small || inside && is_small(radius);
            left = below[x] = radius;
        }
    }
    bool wide_ends = ends && range.r < -WIDE_PX;
    range.a = float((small ? HAS_SMALL : 0) + (ends ? HAS_END : 0) + (wide_ends ? HAS_WIDE_END : 0));
}

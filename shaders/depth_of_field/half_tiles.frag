#version 450 core
// What is blurred how far in each tile, from half an image.
//
// Input:  surfaces (half_surfaces.frag). TILE: side of a tile in its texels.
// Output: r, g = least and greatest signed RADIUS (px of image width); b = the greatest in front of the focus,
//         -1e4 for none; a = 1 where a pixel is less blurred than SMALL_PX of that pass, else 0.
#include "eyes.glsl"
#include "half_coverage.glsl"

uniform eye_image surfaces;

out vec4 range;

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    ivec2 last = size_of(surfaces) - 1;
    range = vec4(1e4, -1e4, -1e4, 0.0);
    for (int y = 0; y < TILE; ++y)
        for (int x = 0; x < TILE; ++x) {
            float radius = texel_of(surfaces, min(first + ivec2(x, y), last)).a;
            range.rg = vec2(min(range.r, radius), max(range.g, radius));
            range.b = radius < -0.5 ? max(range.b, radius) : range.b;
            range.a = is_small(radius) ? 1.0 : range.a;
        }
}

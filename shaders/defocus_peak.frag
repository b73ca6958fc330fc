#version 450 core
// The largest circle of confusion of each tile before its limit, for the record.
//
// Input:  depth, focus (include/defocus.glsl). TILE: side of a tile in pixels, even.
// Output: largest |RADIUS| in pixels of image width, peripheral blur left out; one texel per tile.
//         It grows away from the focus, so that the nearest or the farthest point has it; a tile of
//         a canted eye counts as being where its middle is.
// Source: defocus.frag.
#include "coc.glsl"
#include "defocus.glsl"

out float peak;

void main() {
    ivec2 size = textureSize(depth, 0);
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    ivec2 last = min(first + TILE, size) - 1;
    float nearest = 0.0, farthest = 1.0;
    for (int y = first.y; y <= last.y; y += 2)
        for (int x = first.x; x <= last.x; x += 2) {
            vec4 z = textureGather(depth, vec2(x + 1, y + 1) / vec2(size));  // 2 x 2 texels
            nearest = max(nearest, max(max(z.x, z.y), max(z.z, z.w)));
            farthest = min(farthest, min(min(z.x, z.y), min(z.z, z.w)));
        }
    vec2 middle = (0.5 * vec2(first + last) + 0.5) / vec2(size);
    peak = max(abs(unlimited_radius_at(nearest, middle)), abs(unlimited_radius_at(farthest, middle)));
}

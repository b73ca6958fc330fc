#version 450 core
// The largest circle of confusion of each tile before its limit, for the record.
//
// Input:  depth, focus (include/defocus.glsl). TILE: side of a tile in pixels.
// Output: w = largest |RADIUS| in pixels of image width, peripheral blur left out; one texel per tile.
#include "coc.glsl"
#include "defocus.glsl"

out vec4 peak;

void main() {
    ivec2 size = textureSize(depth, 0);
    ivec2 first = ivec2(gl_FragCoord.xy) * TILE;
    ivec2 end = min(first + TILE, size);
    peak = vec4(0.0);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) {
            ivec2 pixel = ivec2(x, y);
            peak.w = max(peak.w, abs(unlimited_radius_at(pixel, (vec2(pixel) + 0.5) / vec2(size))));
        }
}

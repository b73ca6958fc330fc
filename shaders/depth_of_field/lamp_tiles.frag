#version 450 core
// In which tiles there are lamps behind the focus, and how wide their discs are.
//
// Input:  colour_and_coc (colour_and_coc.frag), of what is behind near things where there is; tiles
//         (coc_tile_min_max.frag). TILE: side of a tile (px).
// Output: the widest RADIUS (px) of a lamp, 0 without.
#include "eyes.glsl"
#include "coc.glsl"

uniform eye_image colour_and_coc;
uniform eye_image tiles;

out float lamp_px;

void main() {
    ivec2 middle = ivec2(gl_FragCoord.xy);
    ivec2 first = TILE * middle, end = min(first + TILE, size_of(colour_and_coc));
    int rows = texel_of(tiles, middle).g > 0.5 ? end.y : first.y;
    float found = 0.0;
    for (int y = first.y; y < rows; ++y)
        for (int x = first.x; x < end.x; ++x) {
            vec4 q = texel_of(colour_and_coc, ivec2(x, y));
            found = max(max(q.r, q.g), q.b) > OUTSHINES ? max(found, q.a) : found;
        }
    lamp_px = found;
}

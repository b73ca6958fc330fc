#version 450 core
// The longest half streak among a tile and its eight neighbours (NeighborMax): a tile is as wide
// as the longest half streak, so nothing from further away can reach it.
//
// Input:  tiles of streak_tiles.frag.
// Output: xy = longest half streak around, px; z = length of the shortest around.
uniform sampler2D tiles;

out vec4 longest;

void main() {
    ivec2 last = textureSize(tiles, 0) - 1;
    longest = vec4(0.0, 0.0, 1e4, 0.0);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            vec4 t = texelFetch(tiles, clamp(ivec2(gl_FragCoord.xy) + ivec2(x, y), ivec2(0), last), 0);
            longest.xy = dot(t.xy, t.xy) > dot(longest.xy, longest.xy) ? t.xy : longest.xy;
            longest.z = min(longest.z, t.z);
        }
}

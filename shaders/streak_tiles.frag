#version 450 core
// The longest half streak of each tile (McGuire et al. 2012, TileMax), one axis at a time.
//
// Input:  x-pass (AXIS 0): streaks.frag; y-pass (AXIS 1): the result of the x-pass.
// Output: xy = longest half streak in the tile, px; z = length of the shortest; w = length of the
//         longest without the limit.
uniform sampler2D source;

out vec4 tile;

void main() {
    ivec2 last = textureSize(source, 0) - 1;
    ivec2 step_px = AXIS == 0 ? ivec2(1, 0) : ivec2(0, 1);
    ivec2 first = ivec2(gl_FragCoord.xy) * (1 + step_px * (TILE - 1));
    tile = vec4(0.0, 0.0, 1e4, 0.0);
    for (int i = 0; i < TILE; ++i) {
        vec4 s = texelFetch(source, min(first + i * step_px, last), 0);
        tile.xy = dot(s.xy, s.xy) > dot(tile.xy, tile.xy) ? s.xy : tile.xy;
        tile.z = min(tile.z, AXIS == 0 ? length(s.xy) : s.z);
        tile.w = max(tile.w, s.w);
    }
}

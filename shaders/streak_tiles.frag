#version 450 core
// The longest half streak of each tile (McGuire et al. 2012, TileMax), one axis at a time.
//
// Input:  x-pass (AXIS 0): streaks.frag; y-pass (AXIS 1): the result of the x-pass.
// Output: xy = longest half streak in the tile, px, without the limit; z = length of the shortest,
//         with it; w = steepness: the most by which half streaks of two pixels side by side differ.
uniform sampler2D source;

out vec4 tile;

ivec2 last = textureSize(source, 0) - 1;

#if AXIS == 0
vec4 summary(ivec2 at) {
    vec4 s = texelFetch(source, min(at, last), 0);
    vec2 right = texelFetch(source, min(at + ivec2(1, 0), last), 0).xy;
    vec2 up = texelFetch(source, min(at + ivec2(0, 1), last), 0).xy;
    float reach = length(s.xy);
    vec2 unlimited = s.w > 1.001 * reach ? s.xy * (s.w / max(reach, 1e-6)) : s.xy;
    return vec4(unlimited, reach, max(length(right - s.xy), length(up - s.xy)));
}
#else
vec4 summary(ivec2 at) {
    return texelFetch(source, min(at, last), 0);
}
#endif

void main() {
    ivec2 step_px = AXIS == 0 ? ivec2(1, 0) : ivec2(0, 1);
    ivec2 first = ivec2(gl_FragCoord.xy) * (1 + step_px * (TILE - 1));
    tile = vec4(0.0, 0.0, 1e4, 0.0);
    for (int i = 0; i < TILE; ++i) {
        vec4 s = summary(first + i * step_px);
        tile.xy = dot(s.xy, s.xy) > dot(tile.xy, tile.xy) ? s.xy : tile.xy;
        tile.z = min(tile.z, s.z);
        tile.w = max(tile.w, s.w);
    }
}

#version 450 core
// The streaks of a whole frame: a point for each row of tiles, all on the only pixel of a 1x1 target, which
// keeps the greatest of rgb and the sum of a.
//
// Input:  gl_VertexID, one for each row of tiles; tile_max (tile_max.frag).
// Output: streaks, of the row: x = longest half velocity, px, without the limit; y = steepness of the
//         steepest tile; z = minus the length of the shortest half velocity; w = what the row adds to
//         the mean, over all tiles of the frame, of their longest half velocities.
uniform sampler2D tile_max;

flat out vec4 streaks;

void main() {
    ivec2 tiles = textureSize(tile_max, 0);
    streaks = vec4(0.0, 0.0, -1e30, 0.0);
    for (int x = 0; x < tiles.x; ++x) {
        vec4 tile = texelFetch(tile_max, ivec2(x, gl_VertexID), 0);
        float longest_px = length(tile.xy);
        streaks.xyz = max(streaks.xyz, vec3(longest_px, tile.w, -tile.z));
        streaks.w += longest_px / float(tiles.x * tiles.y);
    }
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    gl_PointSize = 1.0;
}

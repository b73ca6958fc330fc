#version 450 core
// A square point on each tile of one KIND; the other tiles are put outside the image.
//
// Input:  gl_VertexID, one for each tile; longest (streak_neighbours.frag).
// Output: the point in clip space of the image rounded up to whole tiles (as tap_tiles.vert).
#include "streak_kinds.glsl"

uniform sampler2D longest;

void main() {
    ivec2 tiles = textureSize(longest, 0);
    ivec2 tile = ivec2(gl_VertexID % tiles.x, gl_VertexID / tiles.x);
    bool drawn = texelFetch(longest, tile, 0).z == KIND;
    vec2 middle = (vec2(tile) + 0.5) / vec2(tiles);
    gl_PointSize = float(POINT_PX);
    gl_Position = vec4(drawn ? 2.0 * middle - 1.0 : vec2(-2.0), 0.0, 1.0);
}

#version 450 core
// A square for each tile of one KIND; the other tiles collapse into nothing.
//
// Input:  gl_VertexID, six for each tile; longest (streak_neighbours.frag); velocity for its size.
// Output: the square in clip space; what reaches over the image is clipped.
#include "streak_kinds.glsl"

uniform sampler2D longest;
uniform sampler2D velocity;

const ivec2 CORNERS[6] = ivec2[](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1),
                                 ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));

void main() {
    int columns = textureSize(longest, 0).x;
    ivec2 tile = ivec2(gl_VertexID / 6 % columns, gl_VertexID / 6 / columns);
    bool drawn = texelFetch(longest, tile, 0).z == KIND;
    vec2 corner = vec2(TILE * (tile + CORNERS[gl_VertexID % 6]));
    vec2 size_px = vec2(textureSize(velocity, 0));
    gl_Position = drawn ? vec4(2.0 * corner / size_px - 1.0, 0.0, 1.0) : vec4(0.0, 0.0, 0.0, 1.0);
}

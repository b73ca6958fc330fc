#version 450 core
// A rectangle with a picture on it: an eye's image in a window, or a panel that stands in the room.
//
// Input:  gl_VertexID 0 to 3, as a triangle strip.
// Output: uv in [0, 1] over the picture, lower left corner first.
//
//   2--3     The rectangle is 1 wide and 1 high around its own origin, facing +Z:
//   |\ |     clip_from_picture places it and gives it its size.
//   | \|
//   0--1
uniform mat4 clip_from_picture;
out vec2 uv;

void main() {
    uv = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = clip_from_picture * vec4(uv - 0.5, 0.0, 1.0);
}

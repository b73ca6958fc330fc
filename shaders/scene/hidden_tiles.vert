#version 450 core
// Tiles of which no lens shows anything, on the near plane: depth 1, so that nothing is drawn there.
//
// Input:  corner_of_eye in [0, 1], of triangles that cover the tiles.
// Output: depth alone.
in vec3 corner_of_eye;

void main() {
    gl_Position = vec4(2.0 * corner_of_eye.xy - 1.0, 1.0, 1.0);
}

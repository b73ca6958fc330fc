#version 450 core
// One triangle that covers the image; no vertex buffer.
//
// Input:  gl_VertexID 0, 1, 2. CORNERS: corner in [0, 1], of triangles that cover a part of the image.
// Output: uv in [0, 1] over the image, lower left corner first.
//
//   (0,2)
//     |\            Half of a square twice as large as the image:
//     | \           no seam along a diagonal, each pixel shaded once.
//   --+--+
//     |  |\         Depth is 0 = infinity in reverse-Z.
//   (0,0)-(2,0)
#ifdef CORNERS
in vec2 corner;
#else
vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
#endif
out vec2 uv;

void main() {
    uv = corner;
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}

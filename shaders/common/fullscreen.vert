#version 450 core
// One triangle that covers the image; no vertex buffer.
//
// Input:  corner.glsl.
// Output: uv in [0, 1] over the image, lower left corner first.
//
//   (0,2)
//     |\            Half of a square twice as large as the image:
//     | \           no seam along a diagonal, each pixel shaded once.
//   --+--+
//     |  |\         Depth is 0 = infinity in reverse-Z.
//   (0,0)-(2,0)
#define EYE eye
#include "eyes.glsl"
#include "corner.glsl"

out vec2 uv;

void main() {
    uv = corner;
    draw_in_layer();
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}

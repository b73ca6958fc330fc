#version 450 core
// Cuts out what an alpha mask leaves open; compiled for ALPHA_MASK materials only.
//
// Input:  base colour alpha = factor * image * vertex colour.
// Output: depth, or nothing.
#include "surface.glsl"

layout(binding = 0) uniform sampler2D base_color_image;
in vec2 uv;
in float alpha;

void main() {
    float covered = base_color.a * alpha;
#ifdef BASE_COLOR_IMAGE
    covered *= texture(base_color_image, uv).a;
#endif
    if (covered < reflection.z) discard;
}

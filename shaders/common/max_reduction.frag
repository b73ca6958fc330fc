#version 450 core
// See max_reduction.vert, or another that sums up. Output: the values themselves, and the first once more,
// for a target that keeps it over all images.
flat in vec3 greatest;

layout(location = 0) out vec4 of_image;
layout(location = 1) out float of_all;

void main() {
    of_image = vec4(greatest, 0.0);
    of_all = greatest.x;
}

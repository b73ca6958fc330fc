#version 450 core
// ALPHA_MASK cuts out what an alpha mask leaves open; SEMANTIC writes semantic weights.
// Compiled where at least one of both is needed.
//
// Input:  base colour alpha = factor * image * vertex colour; semantic weight of the thing.
// Output: depth, or nothing; SEMANTIC: the weight.
#include "surface.glsl"

#ifdef ALPHA_MASK
layout(binding = 0) uniform sampler2D base_color_image;
in vec2 uv;
in float alpha;
#endif
#ifdef SEMANTIC
flat in float semantic_weight;
out float weight;
#endif

void main() {
#ifdef ALPHA_MASK
    float covered = base_color.a * alpha;
#ifdef BASE_COLOR_IMAGE
    covered *= texture(base_color_image, uv).a;
#endif
    if (covered < reflection.z) discard;
#endif
#ifdef SEMANTIC
    weight = semantic_weight;
#endif
}

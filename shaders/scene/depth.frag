#version 450 core
// ALPHA_MASK cuts out what an alpha mask leaves open; SEMANTIC writes semantic weights.
// Compiled where at least one of both is needed.
//
// Input:  base colour alpha = factor * image * vertex colour; semantic weight of the instance.
// Output: depth, or nothing; SEMANTIC: the weight.
#ifdef ALPHA_MASK
#include "material.glsl"
uniform sampler2DArray base_color_images;
in vec2 uv;
#ifdef UV_1
in vec2 uv_1;
#else
const vec2 uv_1 = vec2(0.0);
#endif
in float alpha;
flat in int material_index;
#endif
#ifdef SEMANTIC
flat in float semantic_weight;
out float weight;
#endif

void main() {
#ifdef ALPHA_MASK
    Material material = materials[material_index];
    float covered = material.base_color.a * alpha;
#ifdef BASE_COLOR_IMAGE
    covered *= texture(base_color_images, vec3(on_image(material, BASE_COLOR, uv, uv_1), material.layers.x)).a;
#endif
    if (covered < material.reflection.z) discard;
#endif
#ifdef SEMANTIC
    weight = semantic_weight;
#endif
}

#version 450 core
// Depth only: shadow maps, focus rays and the autofocus zone.
//
// Input:  vertices; relative_from_node rows as in scene.vert. SKIN: joints (include/skin.glsl).
// Output: position in any reverse-Z clip space; ALPHA_MASK, SEMANTIC: what depth.frag needs.
#ifdef SKIN
#include "skin.glsl"
#endif
in vec3 in_position;
in vec2 in_uv;
#ifdef UV_1
in vec2 in_uv_1;
out vec2 uv_1;
#endif
in vec4 in_color;
in vec4 in_relative_x;
in vec4 in_relative_y;
in vec4 in_relative_z;
in float in_material;
in vec4 in_thing;  // x: number of the view, w: semantic weight
layout(std140, binding = 3) uniform Clip {
    mat4 clips_from_relative[VIEWS];
};
#ifdef ALPHA_MASK
out vec2 uv;
out float alpha;
flat out int material_index;
#endif
#ifdef SEMANTIC
flat out float semantic_weight;
#endif

void main() {
    vec4 position = vec4(in_position, 1.0);
    vec4 x = in_relative_x, y = in_relative_y, z = in_relative_z;
#ifdef SKIN
    mat4 now = bent(0);
    x = now * x, y = now * y, z = now * z;
#endif
    vec3 relative = vec3(dot(x, position), dot(y, position), dot(z, position));
    gl_Position = clips_from_relative[int(in_thing.x)] * vec4(relative, 1.0);
#ifdef ALPHA_MASK
    uv = in_uv;
#ifdef UV_1
    uv_1 = in_uv_1;
#endif
    alpha = in_color.a;
    material_index = int(in_material);
#endif
#ifdef SEMANTIC
    semantic_weight = in_thing.w;
#endif
}

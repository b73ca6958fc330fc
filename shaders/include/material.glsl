// Materials of a scene; render/materials.py fills them by these names.
//
// Things with different materials are drawn together: each knows the index of its own in the block
// that is bound. MATERIALS: how many a block has. Add a field here and in `material_blocks`.
// UV_MAPS: some image of the material is not simply where the first texture coordinates are.

struct Material {
    vec4 base_color;    // rgba, linear
    vec4 emissive;      // rgb: radiance, a: scale of the normal map
    vec4 reflection;    // x: metallic, y: roughness, z: alpha cut-off
    vec4 layers;        // of base colour, normal, metal-roughness and emission in their arrays
    vec4 uv_u[4];       // of each image, xyz: its u = dot(xyz, (u, v, 1)), w: which coordinates (0, 1)
    vec4 uv_v[4];       // xyz: the same for v
};

layout(std140, binding = 2) uniform Materials {
    Material materials[MATERIALS];
};

const int BASE_COLOR = 0, NORMAL = 1, METALLIC_ROUGHNESS = 2, EMISSIVE = 3;

// Where a vertex with these texture coordinates is on an image of a material.
// Source: KHR_texture_transform; UvMap of scene/data.py is the twin.
vec2 on_image(Material material, int image, vec2 uv_0, vec2 uv_1) {
#ifdef UV_MAPS
    vec3 at = vec3(material.uv_u[image].w < 0.5 ? uv_0 : uv_1, 1.0);
    return vec2(dot(material.uv_u[image].xyz, at), dot(material.uv_v[image].xyz, at));
#else
    return uv_0;
#endif
}

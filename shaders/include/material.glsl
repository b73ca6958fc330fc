// Materials of a scene; render/materials.py fills them by these names.
//
// Things with different materials are drawn together: each knows the index of its own in the block
// that is bound. MATERIALS: how many a block has. Add a field here and in `material_blocks`.

struct Material {
    vec4 base_color;    // rgba, linear
    vec4 emissive;      // rgb: radiance, a: scale of the normal map
    vec4 reflection;    // x: metallic, y: roughness, z: alpha cut-off
    vec4 layers;        // of base colour, normal, metal-roughness and emission in their arrays
};

layout(std140, binding = 2) uniform Materials {
    Material materials[MATERIALS];
};

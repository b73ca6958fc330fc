// Bends a mesh by its joints: linear blend skinning.
//
// Input:  six rows for each joint of all skins: of place_from_bind now, and a frame ago.
// Output: bent(0) now, bent(1) a frame ago: the transpose of a vertex's place_from_bind.
// Twin: scene/animation.py. Source: Khronos glTF 2.0, section 3.7.3.

layout(std430, binding = 0) readonly buffer Joints {
    vec4 joint_rows[];
};
in uvec4 in_joints;      // among those of the mesh's skin
in vec4 in_weights;      // add up to 1
in float in_first_joint; // of the skin

mat4 bent(int moment) {
    mat4 sum = mat4(0.0);
    for (int i = 0; i < 4; i++) {
        int row = 6 * int(in_first_joint + float(in_joints[i])) + 3 * moment;
        sum += in_weights[i] * mat4(joint_rows[row], joint_rows[row + 1], joint_rows[row + 2], vec4(0.0));
    }
    sum[3] = vec4(0.0, 0.0, 0.0, 1.0);
    return sum;
}

#version 450 core
// Places a vertex in the view, and where it was a frame ago.
//
// Input:  vertices; one row per instance: relative_from_node (three rows of a 3x4 matrix).
//         VELOCITY: also previous_relative_from_node, with the PRESENT eye as origin.
//         LENS: one point of the lens (include/lens.glsl). SKIN: joints (include/skin.glsl).
// Output: reverse-Z clip position; world-space (relative) position and normal.
//         VELOCITY: own_motion, 1 where more than the eye moves; clip positions now and before.
#include "view.glsl"
#ifdef LENS
#include "lens.glsl"
#endif

#ifdef SKIN
#include "skin.glsl"
#endif

in vec3 in_position;
in vec4 in_normal;
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
in vec4 in_thing;  // x: share of ambient light, y: 1 = head-locked, z: bit set of its lamps
#ifdef VELOCITY
in vec4 in_previous_x;
in vec4 in_previous_y;
in vec4 in_previous_z;
out vec4 present_clip;
out vec4 previous_clip;
flat out float own_motion;
#endif

out vec3 relative;
out vec3 normal;
out vec2 uv;
#ifdef VERTEX_COLORS
out vec4 color;
#endif
flat out vec2 thing;  // x: share of ambient light, y: bit set of lamps
flat out int material_index;

vec3 cofactor(vec3 n, vec3 x, vec3 y, vec3 z) {
    // The inverse transpose keeps normals upright under uneven scale; its sign keeps mirrors right.
    vec3 yz = cross(y, z);
    return vec3(dot(yz, n), dot(cross(z, x), n), dot(cross(x, y), n)) * sign(dot(x, yz));
}

void main() {
    vec4 position = vec4(in_position, 1.0);
    vec4 x = in_relative_x, y = in_relative_y, z = in_relative_z;
#ifdef SKIN
    mat4 now = bent(0);
    x = now * x, y = now * y, z = now * z;
#endif
    relative = vec3(dot(x, position), dot(y, position), dot(z, position));
    normal = cofactor(in_normal.xyz, x.xyz, y.xyz, z.xyz);
    uv = in_uv;
#ifdef UV_1
    uv_1 = in_uv_1;
#endif
#ifdef VERTEX_COLORS
    color = in_color;
#endif
    thing = in_thing.xz;
    material_index = int(in_material);
    gl_Position = clip_now(relative);
#ifdef VELOCITY
    vec4 before_x = in_previous_x, before_y = in_previous_y, before_z = in_previous_z;
#ifdef SKIN
    mat4 then = bent(1);
    before_x = then * before_x, before_y = then * before_y, before_z = then * before_z;
#endif
    vec3 before = vec3(dot(before_x, position), dot(before_y, position), dot(before_z, position));
    // A head-locked instance is seen by the present eye at both times: its motion in head space.
    bool locked = in_thing.y > 0.5;
    mat3 rotation = locked ? mat3(view_from_relative) : mat3(previous_view_from_relative);
    vec3 from_previous_eye = before + (locked ? vec3(0.0) : eye_delta_m.xyz);
    bool stays = before_x == x && before_y == y && before_z == z && !locked;
#ifdef LENS
    stays = false;  // its place in the image is not the pinhole's, of which the resolve knows
#endif
    own_motion = stays ? 0.0 : 1.0;
    present_clip = gl_Position;
    previous_clip = clip_from_view * vec4(rotation * from_previous_eye, 1.0);
#endif
#ifdef LENS
    float head_depth_m = dot(head_forward.xyz, relative) + head_forward.w;
    gl_Position = through_lens(gl_Position, lens.xy, head_depth_m, lens_focus.x, lens.w,
                               lens_limit.x, lens_limit.y);
#endif
}

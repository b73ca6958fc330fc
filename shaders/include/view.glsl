// One eye's view. Twin: none; render/scene_pass.py fills it by these names.
//
// "Relative" is world axes with the present eye as origin: float32 then has all its digits where
// the eye can see them, however far the eye is from the world's origin.

layout(std140, binding = 0) uniform View {
    mat4 clip_from_view;                   // reverse-Z: clip depth 1 at the near plane, 0 at infinity
    mat4 view_from_relative;               // rotation
    mat4 previous_view_from_relative;      // rotation of the previous view, as motion blur counts it
    mat4 previous_clip_from_clip;          // of what does not move, as motion blur counts the eye
    vec4 eye_delta_m;                      // xyz: eye now less eye before, world axes
    vec4 image_size_px;                    // xy; z: which eye
    vec4 lens;                             // xy: offset per px of radius (NDC), w: infinity m
    vec4 lens_focus;                       // x: m
    vec4 lens_limit;                       // x: px per defocus, y: largest radius px
    vec4 head_forward;                     // xyz: world axes, w: metres of the eye ahead of the head
};

vec4 clip_now(vec3 relative) {
    return clip_from_view * vec4(mat3(view_from_relative) * relative, 1.0);
}

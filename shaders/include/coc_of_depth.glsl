// What turns an eye's depth into signed circle-of-confusion radii: constants and functions.
//
// DepthToCoc (depth_of_field/coc_passes.py) fills the block by its names. Needs coc.glsl before it. LAW_DIOPTRE and LAW_THIN_LENS select the law, PERIPHERAL adds peripheral
// blur. Distances are those along the head's forward axis, or with ALONG_RAY from the head centre along
// each ray. Radii in pixels of image width, negative in front of the focus. Depth is reverse-Z, 0 = sky.

uniform sampler2D focus;            // x = focus distance in m
struct CocOfEye {
    vec3 head_forward_in_view;
    float near_m;
    vec3 eye_in_view;              // from the head centre, m
    float offset_m;                // the eye is this far in front of the head centre
    vec3 peripheral_axis_in_view;  // what peripheral blur is centred on: the head's forward axis, or the gaze
    float peripheral_px;
    vec4 tangents;                 // of the frustum: left, right, up, down
    float px_per_defocus;          // radius per metre or per dioptre of defocus
    float max_radius_px;           // r_max
    float infinity_m;
    float peripheral_exponent;
    float focal_length_m;          // of a thin lens
    float distance_offset_m;       // of a thin lens: added to the distances of focus and point alike
};

layout(std140, binding = 4) uniform CocOfEyes {
    CocOfEye coc_of_eye[EYES];
};

CocOfEye eye = coc_of_eye[EYE];

#ifdef ALONG_RAY
// Distance from the head centre, times z: the hypotenuse of its parts along and across the head's
// forward axis.
float distance_times_depth(float z, vec2 uv) {
    vec3 ray = vec3(mix(eye.tangents.xw, eye.tangents.yz, uv), -1.0);
    float along = eye.near_m * head_depth_slope(eye.tangents, eye.head_forward_in_view, uv) + eye.offset_m * z;
    return length(vec4(along, cross(eye.head_forward_in_view, eye.eye_in_view * z + eye.near_m * ray)));
}

#endif

float focus_m = texelFetch(focus, ivec2(0), 0).x;

// Radius of a depth at an image position, without a limit and without peripheral blur.
float unlimited_radius_at(float z, vec2 uv) {
#ifdef ALONG_RAY
    float near = distance_times_depth(z, uv);
    float offset = 0.0;
#else
    float near = eye.near_m * head_depth_slope(eye.tangents, eye.head_forward_in_view, uv);
    float offset = eye.offset_m;
#endif
#ifdef LAW_THIN_LENS
    // An image at the lens's focal length sees the blur of Eq. 1 under f_d / (f_d - f) times the
    // angle that the aperture has from the distance of the defocus.
    float f_d = lens_focus_m(focus_m + eye.distance_offset_m, eye.focal_length_m,
                             eye.infinity_m + eye.distance_offset_m);
    return unlimited_radius_px(z, near, f_d, offset + eye.distance_offset_m,
                               eye.infinity_m + eye.distance_offset_m,
                               eye.px_per_defocus * f_d / (f_d - eye.focal_length_m), eye.max_radius_px);
#else
    return unlimited_radius_px(z, near, focus_m, offset, eye.infinity_m, eye.px_per_defocus,
                               eye.max_radius_px);
#endif
}

// The same within a limit (px), and with peripheral blur.
float radius_within(float limit_px, float z, vec2 uv) {
    float radius = clamp(unlimited_radius_at(z, uv), -limit_px, limit_px);
#ifdef PERIPHERAL
    vec2 tangent = mix(eye.tangents.xw, eye.tangents.yz, uv);
    float cos_angle = head_depth_slope(eye.tangents, eye.peripheral_axis_in_view, uv)
                    * inversesqrt(1.0 + dot(tangent, tangent));
    radius = add_peripheral_px(radius, cos_angle, eye.peripheral_px, eye.peripheral_exponent, limit_px);
#endif
    return radius;
}

float radius_at(float z, vec2 uv) {
    return radius_within(eye.max_radius_px, z, uv);
}

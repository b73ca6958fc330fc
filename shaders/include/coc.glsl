// Circle of confusion: how far a point spreads, and the disc it spreads over.
//
// Every amount is a RADIUS in pixels of image width; negative in front of the focus distance,
// positive behind it. NumPy twins: vrcomfort/optics/circle_of_confusion.py, where the formulas are
// derived. Source: Carnegie & Rhee 2015, Algorithm 1.

const float PI = 3.14159265358979;

// Metres along the head's forward axis per metre along the eye's axis, at an image position in
// [0, 1]. `tangents` are those of the frustum: left, right, up, down. 1 where nothing is canted.
float head_depth_slope(vec4 tangents, vec3 head_forward_in_view, vec2 uv) {
    vec2 tangent = mix(tangents.xw, tangents.yz, uv);
    return dot(head_forward_in_view.xy, tangent) - head_forward_in_view.z;
}

// Signed radius of a reverse-Z depth (0 = sky), within ±radius_limit_px. near = near_m * slope.
// Metres of defocus are (near + (offset - focus) * z) / z: infinite distances are never formed.
// A focus that is not a number counts as infinity. LAW_DIOPTRE selects the law at compile time.
float signed_radius_px(float depth, float near, float focus_m, float offset_m, float infinity_m,
                       float px_per_defocus, float radius_limit_px) {
    const float LEAST = 1e-9;  // metres; keeps pixels beside or behind the head in front of it
    float focus = focus_m > 0.0 ? min(focus_m, infinity_m) : infinity_m;
    float z = max(depth, max(near, LEAST) / (infinity_m - offset_m));
    float defocus = fma(offset_m - focus, z, near);  // one rounding: near focus all digits cancel
#ifdef LAW_DIOPTRE
    defocus /= focus * max(fma(offset_m, z, near), LEAST);
    float px = px_per_defocus;
#else
    defocus /= z;
    float px = min(px_per_defocus, radius_limit_px / focus);  // a far focus keeps a far range sharp
#endif
    return clamp(defocus * px, -radius_limit_px, radius_limit_px);
}

// Coverage of a point by a disc whose rim falls from 1 to 0 over softness_px. At radius 0.5 and
// softness 1 only the disc's own pixel is covered.
float disc_weight(float distance_px, float radius_px, float softness_px) {
    return clamp((radius_px - distance_px) / softness_px + 0.5, 0.0, 1.0);
}

// Integral of disc_weight over the plane: a blunt cone, or a whole one where the disc is small.
float disc_area_px(float radius_px, float softness_px) {
    float reach = radius_px + 0.5 * softness_px;
    return radius_px >= 0.5 * softness_px
        ? PI * (radius_px * radius_px + softness_px * softness_px / 12.0)
        : PI * reach * reach * reach / (3.0 * softness_px);
}

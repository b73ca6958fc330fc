// Circle of confusion: how far a point spreads, and the disc it spreads over.
//
// Every amount is a RADIUS in pixels of image width; negative in front of the focus distance,
// positive behind it. NumPy twins: vrcomfort/optics/circle_of_confusion.py, where the formulas are
// derived; of margin_px and nearer, tests/oracles/gather.py. Sources: Carnegie & Rhee
// 2015, Algorithm 1; Potmesil & Chakravarty 1982; Hillaire et al. 2008.

const float PI = 3.14159265358979;

// Metres along the head's forward axis per metre along the eye's axis, at an image position in
// [0, 1]. `tangents` are those of the frustum: left, right, up, down. 1 where nothing is canted.
float head_depth_slope(vec4 tangents, vec3 head_forward_in_view, vec2 uv) {
    vec2 tangent = mix(tangents.xw, tangents.yz, uv);
    return dot(head_forward_in_view.xy, tangent) - head_forward_in_view.z;
}

// Signed radius of a reverse-Z depth (0 = sky), without a limit. near = near_m * slope.
// Metres of defocus are (near + (offset - focus) * z) / z: infinite distances are never formed.
// A focus that is not a number counts as infinity. LAW_DIOPTRE selects the laws whose radius is
// proportional to |1/f - 1/d| (dioptre, thin_lens, eye) at compile time; without it, |f - d|.
float unlimited_radius_px(float depth, float near, float focus_m, float offset_m, float infinity_m,
                          float px_per_defocus, float max_radius_px) {
    const float LEAST = 1e-9;  // metres; keeps pixels beside or behind the head in front of it
    float focus = focus_m > 0.0 ? min(focus_m, infinity_m) : infinity_m;
    float z = max(depth, max(near, LEAST) / (infinity_m - offset_m));
    // One rounding, near focus all digits cancel: without precise a compiler may take it apart.
    precise float defocus = fma(offset_m - focus, z, near);
#ifdef LAW_DIOPTRE
    return defocus / (focus * max(fma(offset_m, z, near), LEAST)) * px_per_defocus;
#else
    // A far focus keeps a far range sharp.
    return defocus / z * min(px_per_defocus, max_radius_px / focus);
#endif
}

// The same, within ±max_radius_px.
float signed_radius_px(float depth, float near, float focus_m, float offset_m, float infinity_m,
                       float px_per_defocus, float max_radius_px) {
    float radius = unlimited_radius_px(depth, near, focus_m, offset_m, infinity_m, px_per_defocus,
                                       max_radius_px);
    return clamp(radius, -max_radius_px, max_radius_px);
}

// Distance at which a lens of this focal length is focused: never at or inside that length, where
// f_d - f is 0. Potmesil & Chakravarty 1982.
#ifdef LAW_THIN_LENS
float lens_focus_m(float focus_m, float focal_length_m, float infinity_m) {
    float focus = focus_m > 0.0 ? min(focus_m, infinity_m) : infinity_m;
    return max(focus, CLOSEST_FOCUS * focal_length_m);  // in focal lengths
}
#endif

// Peripheral blur on top of a signed radius (Hillaire et al. 2008, Eq. 5 and 6): it makes discs
// wider and changes neither their sign nor their order in depth. cos_angle: between the pixel and
// the axis that it is centred on; unit_px: radius where 1 / cos_angle - 1 is 1.
float add_peripheral_px(float radius_px, float cos_angle, float unit_px, float exponent,
                        float max_radius_px) {
    const float LEAST = 1e-3;  // 90 degrees and beyond: the radius is at its limit long before
    // A division may be rounded to less than 1, and the power of a negative number is undefined.
    float more = unit_px * pow(max(1.0 / clamp(cos_angle, LEAST, 1.0) - 1.0, 0.0), exponent);
    float sum = min(abs(radius_px) + more, max_radius_px);
    return radius_px < 0.0 ? -sum : sum;
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

// How much nearer (in radius) another point must be to be a surface of its own: well above the
// rounding of half floats, and a slanted surface stays one.
const float MARGIN_PX = 0.125;   // Fitted: python -m bench --only fitted
const float MARGIN_PART = 0.05;  // Fitted: python -m bench --only fitted

float margin_px(float radius) {
    return max(MARGIN_PX, MARGIN_PART * abs(radius));
}

// Light so many times brighter than white, and than what is nearer in its pixel, keeps a disc of its own.
const float OUTSHINES = 8.0;

// 1 for what is much brighter than white, which hardly is wider than what is seen of it.
float lamp_part(vec4 light) {
    return clamp(max(max(light.r, light.g), light.b) / OUTSHINES - 1.0, 0.0, 1.0);
}

// 0 where q is the surface of p or behind it, 1 where it is nearer.
float nearer(float p, float q) {
    return clamp((p - q) / margin_px(p) - 1.0, 0.0, 1.0);
}

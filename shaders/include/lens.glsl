// A lens for the brute-force reference: where one lens sample sees a point.
//
// A point with signed radius s (px) is seen through lens position u (unit disc) s * u from where
// the pinhole sees it. In clip space, with w = d the distance along the eye's axis and an eye that
// shares the head's axis, law `dioptre` is (1/f - 1/d) * w = d/f - 1: affine in d, an exact shear.
// The `linear` law and the limit r_max are not linear in clip space: they hold at vertices only.
// Twin and source: vrcomfort/optics/circle_of_confusion.py.

// Adds the lens displacement. lens_ndc = u * 2 / size_px (y times the pixel aspect). head_depth_m:
// the point's distance from the head centre along the head's forward axis.
vec4 through_lens(vec4 clip, vec2 lens_ndc, float head_depth_m, float focus_m, float infinity_m,
                  float px_per_defocus, float radius_limit_px) {
    float focus = min(focus_m, infinity_m);
    float d = min(head_depth_m, infinity_m);
#ifdef LAW_DIOPTRE
    float defocus = 1.0 / focus - 1.0 / d;
#else
    float defocus = d - focus;
#endif
    // Points at and behind the eye are clipped anyway; only their sign matters.
    float radius = d > 0.0 ? defocus * px_per_defocus : -radius_limit_px;
    clip.xy += lens_ndc * clamp(radius, -radius_limit_px, radius_limit_px) * clip.w;
    return clip;
}

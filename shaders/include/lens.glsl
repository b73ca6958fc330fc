// A lens, for the brute-force reference and for views: where one point of it sees a point.
//
// A point with signed radius s (px) is seen through lens position u (unit disc) s * u from where
// the pinhole sees it. In clip space, with w = d the distance along the eye's axis:
//
//   law `dioptre`  s w = (1/f - 1/d) w = d/f - 1: affine in d, so every triangle is sheared
//                  exactly, also where it passes the eye. The limit r_max is left out: it would
//                  not be affine. Displays that are not canted are assumed (else: at vertices).
//   law `linear`   s w = (d - f) d, and s within its limit: holds at vertices only.
//
// Twin and source: vrcomfort/optics/circle_of_confusion.py.

// Adds the lens displacement. lens_ndc = u * 2 / size_px (y times the pixel aspect). head_depth_m:
// the point's distance from the head centre along the head's forward axis.
vec4 through_lens(vec4 clip, vec2 lens_ndc, float head_depth_m, float focus_m, float infinity_m,
                  float px_per_defocus, float max_radius_px) {
    float focus = focus_m > 0.0 ? min(focus_m, infinity_m) : infinity_m;
    float d = min(head_depth_m, infinity_m);
#ifdef LAW_DIOPTRE
    float radius_times_w = px_per_defocus * (clip.w / focus - (d > 0.0 ? clip.w / d : 1.0));
#else
    float px = min(px_per_defocus, max_radius_px / focus);
    float radius = clamp((d - focus) * px, -max_radius_px, max_radius_px);
    float radius_times_w = radius * clip.w;
#endif
    clip.xy += lens_ndc * radius_times_w;
    return clip;
}

// Discs on a grid: how much of the light of one lands on a place.
//
// Radii in pixels of image width (or in texels of a level), negative in front of the focus. Include
// after coc.glsl. Twins: tests/oracles/gather.py.

uniform float pixel_aspect_of_eye[EYES];  // image pixels per unit, vertical / horizontal
float pixel_aspect = pixel_aspect_of_eye[EYE];

// How far the radius of a disc may be from that of p (px) to count in full as a disc of p's surface;
// 0 where p is sharp, so that nothing but p itself is at p.
float slack_of(float own_px) {
    return min(margin_px(own_px), max(own_px - 0.5, 0.0));
}

// The rim of a disc on the pixel grid falls from 1 to 0 over so many pixels, as smoothstep does: that
// has the variance of a pixel, sqrt(20 / 12).
const float RIM_PX = 1.2909944;

// The radius at which disc_share comes closest to what a lens shows; twin: grid_radius_px, which
// says why. At half a pixel nothing of the disc is on the next pixel.
const float NARROWER_PX = 0.05;  // Fitted: python -m bench --only fitted

float grid_radius_px(float radius) {
    return min(radius - NARROWER_PX, 3.0 * radius - 0.5 - 0.5 * RIM_PX);
}

// PI times the part of the light of a disc of this grid_radius_px that lands on a square pixel.
float disc_share(float away, float grid_radius) {
    float inside = clamp((grid_radius - away) / RIM_PX + 0.5, 0.0, 1.0);
    return inside * inside * (3.0 - 2.0 * inside) / (grid_radius * grid_radius + 1.0 / 12.0);
}

// Radius of a disc in texels so many px wide, which are means of pixels: half of what their box and the rim
// of a disc of texels blur more than those of pixels is made up for, which is closest to the reference.
float disc_texels(float radius_px, float texel_px) {
    float four_variances = (texel_px * texel_px - 1.0) / 2.0;
    return max(sqrt(max(radius_px * radius_px - four_variances, 0.0)) / texel_px, 0.5);
}

// Of half an image: four times what bilinear enlargement adds to the variance: 0.75 px^2, less what the rims have too little.
const float ENLARGED_PX2 = 2.0;  // Fitted: python -m bench --only fitted

// Gathering what other pixels would scatter here: who is behind, who is in front, where the taps are.
//
// Radii in pixels of image width, negative in front of the focus; where one surface ends and the
// next begins is told by radii, which order depth. Include after coc.glsl. Twins:
// vrcomfort/optics/fronts.py; of rings and grid_radius_px, vrcomfort/optics/circle_of_confusion.py.

uniform vec2 directions[4 * RINGS * (RINGS + 1)];  // ring_directions
uniform float pixel_aspect;                        // image pixels per unit, vertical / horizontal

// Half resolution, its taps and its interpolation blur by themselves: their variance together.
const float HALF_VARIANCE_PX2 = 1.67;
// It serves discs of which it is no more than that, and where surfaces mix, wider ones only.
const float ALIKE_PX = 2.6;
const float MIXED_PX = 4.0;

// Whether all that may reach p is about as blurred as p: one surface, whose rims do not show.
bool is_alike(float radius, vec4 tile) {
    return tile.g - tile.r <= 0.08 * abs(radius);
}

// How much nearer (in radius) another point must be to be a surface of its own: well above the
// rounding of half floats, and a slanted surface stays one.
float margin_px(float radius) {
    return max(0.125, 0.05 * abs(radius));
}

// 0 where q is the surface of p or behind it, 1 where it is nearer.
float nearer(float p, float q) {
    return clamp((p - q) / margin_px(p) - 1.0, 0.0, 1.0);
}

// A disc up to 2 px wide on the pixel grid: the radius at which weights of softness 1 have the
// variance of a pixel spread over the disc. Twin: grid_radius_px.
float grid_radius_px(float radius) {
    const float AT[8] = float[](0.5, 0.703, 0.932, 1.11, 1.558, 1.772, 1.928, 1.928);
    float step_ = clamp(4.0 * (radius - 0.5), 0.0, 6.0);
    int i = int(step_);
    return mix(AT[i], AT[i + 1], step_ - float(i));
}

int ring_count(float disc, float spacing) {
    return clamp(int(ceil(disc / spacing - 0.5)), 1, RINGS);
}

// Not in the middle of its annulus but where its mean square distance is.
float ring_radius(int ring, float spacing) {
    return spacing * sqrt(float(ring * ring) + 0.25);
}

// Opacity that a nearer point adds where its disc covers p: the share of its light that lands here.
float front_opacity(float away, float radius, float softness, float area) {
    return disc_weight(away, radius, softness) * area / disc_area_px(radius, softness);
}

// Gathering what other pixels would scatter here: whose discs count, where the taps are.
//
// Radii in pixels of image width, negative in front of the focus; where one surface ends and the
// next begins is told by radii, which order depth. Include after coc.glsl. Twins:
// vrcomfort/optics/fronts.py; of rings and grid_radius_px, vrcomfort/optics/circle_of_confusion.py.

uniform vec2 directions[4 * RINGS * (RINGS + 1)];  // ring_directions
uniform float pixel_aspect;                        // image pixels per unit, vertical / horizontal

// Half resolution, its taps and its interpolation blur by themselves: their variance together.
const float HALF_VARIANCE_PX2 = 1.67;

// Whether all that may reach p is about as blurred as p: at most so many margins apart. Within one
// there is no front; within two the rims do not show where discs are wide.
bool is_alike(float radius, vec4 tile, float margins) {
    return tile.g - tile.r <= margins * margin_px(radius);
}

// How far the radius of a disc may be from that of p (px) to count in full as a disc of p's surface;
// 0 where p is sharp, so that nothing but p itself is at p.
float slack_of(float own_px) {
    return min(margin_px(own_px), max(own_px - 0.5, 0.0));
}

// A disc on the pixel grid: the radius at which weights of softness 1 have the variance of a pixel
// spread over the disc. Twin: grid_radius_px.
float grid_radius_px(float radius) {
    const float AT[12] = float[](0.5, 0.703, 0.932, 1.11, 1.558, 1.772, 1.928, 2.204, 2.521, 2.735,
                                 2.973, 2.973);
    float step_ = clamp(4.0 * (radius - 0.5), 0.0, 10.0);
    int i = int(step_);
    return mix(AT[i], AT[i + 1], step_ - float(i)) + max(radius - 3.0, 0.0);
}

// PI times the part of a disc's light that lands on a square pixel of its plane.
float disc_share(float away, float radius) {
    return disc_weight(away, radius, 1.0) / (radius * radius + 1.0 / 12.0);
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

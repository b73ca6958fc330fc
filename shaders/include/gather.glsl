// Gathering what other pixels would scatter here: whose discs count, where the taps are.
//
// Radii in pixels of image width, negative in front of the focus; where one surface ends and the
// next begins is told by radii, which order depth. Include after coc.glsl. Twins:
// tests/oracles/gather.py; of rings, tests/oracles/circle_of_confusion.py.

uniform vec2 directions[4 * RINGS * (RINGS + 1)];  // ring_directions
uniform float pixel_aspect;                        // image pixels per unit, vertical / horizontal

// Half resolution, its taps and its interpolation blur by themselves: their variance together.
const float HALF_VARIANCE_PX2 = 1.67;

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
float grid_radius_px(float radius) {
    return min(radius - 0.05, 3.0 * radius - 0.5 - 0.5 * RIM_PX);
}

// PI times the part of the light of a disc of this grid_radius_px that lands on a square pixel.
float disc_share(float away, float grid_radius) {
    float inside = clamp((grid_radius - away) / RIM_PX + 0.5, 0.0, 1.0);
    return inside * inside * (3.0 - 2.0 * inside) / (grid_radius * grid_radius + 1.0 / 12.0);
}

int ring_count(float disc, float spacing) {
    return clamp(int(ceil(disc / spacing - 0.5)), 1, RINGS);
}

// Not in the middle of its annulus but where its mean square distance is.
float ring_radius(int ring, float spacing) {
    return spacing * sqrt(float(ring * ring) + 0.25);
}

// Opacity that a nearer point adds where its disc covers p: the share of its light that lands here.
float foreground_opacity(float away, float radius, float softness, float area) {
    return disc_weight(away, radius, softness) * area / disc_area_px(radius, softness);
}

// Kinds of tiles, by what may reach them (defocus_reach.frag): each has a program of its own, because
// renderers on the CPU run both sides of every branch. Signed RADII in px of image width.
const int COPIED = 1;   // nothing is blurred
const int SMALL = 2;    // everything is about alike: bilinear reads of points
const int WIDE = 4;     // alike, and wide enough for half resolution
const int WIDEST = 8;   // alike, and taps so far apart that they read a quarter of it
const int MIXED = 16;   // several surfaces, told apart tap by tap

// Part of the widest radius by which those of one tile's surroundings may differ.
const float ALIKE = 1.0;
// Discs wider than this are blurred at half resolution, whose own blur is that of 2.5 px.
const float HALVED_PX = 4.0;

int tap_kind(vec4 reach) {
    float widest = max(abs(reach.r), abs(reach.g));
    if (widest <= 0.5)
        return COPIED;
    bool alike = reach.g - reach.r <= ALIKE * widest && max(reach.r, -reach.g) > 0.5;
    if (!alike)
        return MIXED;
    if (min(abs(reach.r), abs(reach.g)) <= HALVED_PX)
        return SMALL;
    return widest * widest * 3.14 <= 16.0 * float(TAPS) ? WIDE : WIDEST;
}

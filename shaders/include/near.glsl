// What is drawn over a picture of its own of what lies behind it: things in front of the focus.
//
// RADIUS in pixels of image width, negative in front of the focus.
//
// The picture behind ends where the radius is BEHIND_PX. A surface that goes on beyond is continued in what is
// near by as much as its disc is wide, or the end would show; but nothing of it spreads from there, or a
// silhouette between the two radii would be blurred in both.

// Between 1 to 1.5 and 2 to 2.5 px these err least in `python -m bench.blur --set samples=36 --rounds 1`: the
// half resolution of what is near makes narrower discs too wide.
const float NEAR_PX = 1.5;     // what is blurred more, in front of the focus, continues what is near
const float BEHIND_PX = 2.0;   // what is blurred more is not in the picture behind it
const float FADES_PX = 0.1;    // of radius, in which a surface is taken over

// Part of a pixel that belongs to what is near, or continues it.
float near_part(float radius_px) {
    return clamp((-radius_px - NEAR_PX) / FADES_PX, 0.0, 1.0);
}

// Part of it that the picture behind lacks.
float apart(float radius_px) {
    return clamp((-radius_px - BEHIND_PX) / FADES_PX + 1.0, 0.0, 1.0);
}

// What is drawn over a picture of its own of what lies behind it: things in front of the focus.
//
// RADIUS in pixels of image width, negative in front of the focus.
//
// The picture behind ends where the radius is BEHIND_PX. A surface that goes on beyond is continued in what is
// near by as much as its disc is wide, or the end would show; but nothing of it spreads from there, or a
// silhouette between the two radii would be blurred in both.

const float NEAR_PX = 1.75;    // what is blurred more, in front of the focus, continues what is near
const float BEHIND_PX = 2.25;  // what is blurred more is not in the picture behind it
const float FADES_PX = 0.1;    // of radius, in which a surface is taken over

// Part of a pixel that belongs to what is near, or continues it.
float near_part(float radius_px) {
    return clamp((-radius_px - NEAR_PX) / FADES_PX, 0.0, 1.0);
}

// Part of it that the picture behind lacks.
float apart(float radius_px) {
    return clamp((-radius_px - BEHIND_PX) / FADES_PX + 1.0, 0.0, 1.0);
}

// What is drawn over a picture of its own of what lies behind it: things in front of the focus.
//
// RADIUS in pixels of image width, negative in front of the focus.

const float NEAR_PX = 1.0;        // what is blurred more, in front of the focus, is drawn apart
const float NEAR_IN_FULL_PX = 1.5;  // what is blurred so much is drawn apart in full
const float BEHIND_PX = 2.0;        // what is blurred more is not in the picture behind it

// Part of a pixel that is drawn apart.
float near_part(float radius_px) {
    return clamp((-radius_px - NEAR_PX) / (NEAR_IN_FULL_PX - NEAR_PX), 0.0, 1.0);
}

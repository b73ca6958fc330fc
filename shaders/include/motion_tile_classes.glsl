// Which pass a tile needs, for how the streaks in and around it are.

const float EARLY_OUT = 0.0;  // a copy: nothing around moves far enough to be seen
const float FAST = 1.0;       // the average along each pixel's own streak
const float COMPLEX = 2.0;    // a velocity discontinuity: depth decides what hides what

const float LEAST_PX = 0.25;  // half velocities below this are left alone: half a pixel in all

// By how much another half velocity may differ and still count as moving along.
const float TOLERANCE_PX = 0.25, TOLERANCE_PART = 0.1;  // errors hardly depend on them

float tolerance_px(float half_velocity_px) {
    return TOLERANCE_PX + TOLERANCE_PART * half_velocity_px;
}

// Half velocities of two pixels side by side that differ by more are of objects that pass each other:
// by JUMP of the shorter one, and half a pixel.
#ifndef JUMP
#define JUMP 0.1
#endif

float jump_px(float half_velocity_px) {
    return 0.5 + JUMP * half_velocity_px;
}

float cross_product(vec2 a, vec2 b) {
    return a.x * b.y - a.y * b.x;
}

// How far the end of a half velocity lies beside the line of another, px.
float beside_px(vec2 half_velocity, vec2 line) {
    return abs(cross_product(half_velocity, line)) / max(length(line), 1e-6);
}

// Whether a half velocity goes clearly another way than a line: at an angle of asin(1 / 5) = 11.5
// degrees if it is long, of more if it is short.
const float CROSSING_PART = 0.2;  // the sine of that angle

bool crosses(vec2 half_velocity, vec2 line) {
    return beside_px(half_velocity, line) > LEAST_PX + CROSSING_PART * length(half_velocity);
}

// The one of two half velocities whose end lies farther beside a line; the first where both do.
vec2 farther_beside(vec2 line, vec2 a, vec2 b) {
    return abs(cross_product(b, line)) > abs(cross_product(a, line)) ? b : a;
}

// Foregrounds are looked for along one line or two. The share of a foreground with half velocity u
// that counts along `line`, where the rest counts along `other`: shares are as the squares of cot(angle of u to
// the line). What goes along one counts there only, what goes at right angles to one does not count
// there, and the two shares make 1. All of it where there is no other line, (0, 0).
float share_along(vec2 u, vec2 line, vec2 other) {
    float here = dot(u, line) * cross_product(u, other);
    float there = dot(u, other) * cross_product(u, line);
    return there == 0.0 ? 1.0 : here * here / max(here * here + there * there, 1e-30);
}

// around: the longest half velocity that comes here; shortest: of the tile; steepness: see
// tile_max.frag. Where streaks change slowly, samples move along with the pixel; only where they
// jump can one object be seen to pass before another.
float class_of(vec2 around, float shortest, float steepness) {
    if (length(around) < LEAST_PX)
        return EARLY_OUT;
    return steepness <= jump_px(shortest) ? FAST : COMPLEX;
}

// Whether any tile of a frame may be COMPLEX; frame: of all its tiles (frame_streaks.comp).
bool may_be_complex(vec3 frame) {
    return frame.x >= LEAST_PX && frame.y > jump_px(frame.z);
}

// How a frame is averaged: by its longest half velocity, in one step or in two; in two, where all of it
// moves far along one axis, as in head turns, with half as many averages along that axis.

const float SHORT = 0.0;
const float LONG = 1.0;
const float LONG_X = 2.0;  // an average for two pixels side by side
const float LONG_Y = 3.0;  // one above the other

// By how much half velocities may lean towards the other axis, where wider averages would blur as well:
// 53 degrees, at which they blur by 0.8 px (standard deviation).
const float MOST_SLOPE = 4.0 / 3.0;

// slopes: the greatest |y| / |x| and |x| / |y| of the tiles' longest half velocities.
float kind_of(float shortest, float longest, vec2 slopes) {
    if (longest <= ONE_STEP_PX)
        return SHORT;
    if (HALVES == 0 || shortest <= ONE_STEP_PX)
        return LONG;
    return slopes.x <= MOST_SLOPE ? LONG_X : slopes.y <= MOST_SLOPE ? LONG_Y : LONG;
}

// Which pass a tile needs, for how the streaks in and around it are.

const float STILL = 0.0;   // none: nothing around moves far enough to be seen
const float ALIKE = 1.0;   // the plain average along each pixel's own streak
const float MIXED = 2.0;   // who hides whom has to be looked at

const float LEAST_PX = 0.25;  // half streaks below this are left alone: half a pixel in all

// By how much another half streak may differ and still count as moving along.
float tolerance_px(float half_streak_px) {
    return 0.25 + 0.1 * half_streak_px;
}

// Half streaks of two pixels side by side that differ by more are of things that pass each other.
float jump_px(float half_streak_px) {
    return 0.5 + 0.1 * half_streak_px;
}

// around: the longest half streak that comes here; shortest: of the tile; steepness: see
// streak_tiles.frag. Where streaks change slowly, taps move along with the pixel; only where they
// jump can one thing be seen to pass before another.
float kind_of(vec2 around, float shortest, float steepness) {
    if (length(around) < LEAST_PX)
        return STILL;
    return steepness <= jump_px(shortest) ? ALIKE : MIXED;
}

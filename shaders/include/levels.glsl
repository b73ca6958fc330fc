// On which level a disc is drawn: level 0 are the pixels, each next one has texels twice as wide. Two levels
// share the discs between them, so that nothing shows where one takes over.
//
// EXACT_PX: RADIUS (px of image width) up to which a disc is summed over its pixels; WIDER: how many times
// more texels a radius may have on the other levels; LEVELS: how many there are; FADED: part of its widest disc
// from which a level shares with the next. EACH_COARSER_LEVEL(f): f(1) f(2) … of all but the pixels, since
// software rasterisers read the textures of a loop more slowly.
// Each class of tiles shares discs between the same levels: a disc that lies in several is of one piece.
// Twin: vrcomfort/optics/blur_kernels.py.

// Bits of a tile: its levels, and above them one for each quadrant in which a surface ends, in order of rows.
const int LEVEL_BITS = 8;

// RADIUS of the widest disc that is drawn on a level (px), unless it is the last.
float widest_on(int level) {
    return EXACT_PX * (level > 0 ? WIDER * float(1 << level) : 1.0);
}

// Part of a disc that is drawn on coarser levels than this one.
float coarser_part(int level, float radius_px) {
    return level >= LEVELS - 1 ? 0.0 : clamp((radius_px / widest_on(level) - FADED) / (1.0 - FADED), 0.0, 1.0);
}

// Part of a disc that is drawn on this level.
float level_part(int level, float radius_px) {
    return (level > 0 ? coarser_part(level - 1, radius_px) : 1.0) - coarser_part(level, radius_px);
}

// Bits of the levels that draw a disc; none where it stays within its pixel.
int levels_of(float radius_px) {
    int found = 0;
    for (int level = 0; level < (radius_px > 0.5 ? LEVELS : 0); ++level)
        found |= level_part(level, radius_px) > 0.0 ? 1 << level : 0;
    return found;
}

// What a tile of the image needs (coc_tile_dilate.frag).
const int IN_FOCUS = 0;              // nothing is blurred
const int FAST = 1;                  // no depth discontinuity within reach: discs are plain means
const int FAST_HALF_RESOLUTION = 2;  // the same, and some discs are summed at half resolution
const int COMPLEX = 3;               // foreground spreads over background, and does not leak when sharp

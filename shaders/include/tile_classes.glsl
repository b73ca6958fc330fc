// What a tile of the image needs (coc_tile_dilate.frag).
const int SHARP = 0;        // nothing is blurred
const int ONE_SURFACE = 1;  // no surface ends within reach: discs are means of whatever is around
const int WIDE = 2;         // the same, and some discs are summed at half resolution
const int LAYERED = 3;      // what is nearer spreads over what is farther, and does not leak when sharp

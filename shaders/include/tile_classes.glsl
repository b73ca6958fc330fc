// What a tile of the image needs (coc_tile_dilate.frag, half_tile_dilate.frag).
const int IN_FOCUS = 0;                 // nothing is blurred
const int FAST = 1;                     // no depth discontinuity within reach: discs are plain means
const int FAST_HALF_RESOLUTION = 2;     // the same, and some discs are summed at half resolution (12 samples: all)
const int COMPLEX_HALF_RESOLUTION = 3;  // with 12 samples: complex, and all discs are summed at half resolution
const int COMPLEX = 4;                  // foreground spreads over background, and does not leak when sharp
const int CUT = 5;                      // something near cuts the disc of a lamp behind the focus: complex as well
// And what it needs before that, and after (near_tiles.frag); a tile BEHIND is NEAR too.
const int NEAR = 1;                     // the disc of something near comes here, and its silhouette is not far
const int BEHIND = 2;                   // what lies behind something near is drawn
// And what is in it before that, with 12 samples (half_tiles.frag): bits.
const int HAS_SMALL = 1;                // a pixel is less blurred than SMALL_PX of half_surfaces.frag
const int HAS_END = 256;                // a surface ends: above LEVEL_BITS, as in coc_tile_min_max.frag
const int HAS_WIDE_END = 512;           // and something near is blurred more than WIDE_PX
const int HAS_ALL = 769;                // the last of those with it

// Kinds of tiles: each has a program of its own, because renderers on the CPU run both sides of every
// branch.
const int COPIED = 1;    // nothing is blurred
const int WIDE = 8;      // wide discs of one surface: they are drawn at half resolution

// With rings (blur_kinds.frag): how else a tile is drawn,
const int ALIKE = 2;     // small discs of one surface
const int SMALL = 4;     // small discs of several surfaces
const int LAYERED = 16;  // wide discs and others
// and what the tiles around need of it.
const int POINTS = 32;   // colours and radii
const int HALVES = 64;   // half of them
const int LAYERS = 128;  // wide discs at half resolution

// With taps (tap_reach.frag).
const int FEW = 2;       // everything is about alike, or nearly sharp, and so small that few reads do
const int FINE = 4;      // alike: bilinear reads of the image
const int WIDEST = 16;   // wide discs from a quarter of the image
const int MIXED = 32;    // several surfaces, told apart tap by tap
const int APART = 64;    // the same, with discs so wide that taps are far apart

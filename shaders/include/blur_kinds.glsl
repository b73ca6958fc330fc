// What is drawn on a tile (blur_kinds.frag). One of the first five is what it shows: each has a
// program of its own, because renderers on the CPU run both sides of every branch. The others are
// what the tiles around need of it.
const int COPIED = 1;    // nothing is blurred
const int ALIKE = 2;     // small discs of one surface
const int SMALL = 4;     // small discs of several surfaces
const int WIDE = 8;      // wide discs of one surface: they come from half resolution
const int LAYERED = 16;  // wide discs and others
const int POINTS = 32;   // colours and radii
const int HALVES = 64;   // half of them
const int LAYERS = 128;  // wide discs at half resolution

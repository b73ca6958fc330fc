// Kinds of tiles, by what may reach them (tap_reach.frag): each has a program of its own, because
// renderers on the CPU run both sides of every branch.
const int COPIED = 1;   // nothing is blurred
const int FEW = 2;      // everything is about alike, and so small that half the reads cover it
const int FINE = 4;     // alike: bilinear reads of points
const int SMOOTH = 8;   // alike, and taps so far apart that they read a half of the points
const int WIDE = 16;    // alike, and wide enough to be drawn at half resolution
const int WIDEST = 32;  // the same from a quarter of the points
const int MIXED = 64;   // several surfaces, told apart tap by tap

// Kinds of tiles, by what may reach them (tap_reach.frag): each has a program of its own, because
// renderers on the CPU run both sides of every branch.
const int COPIED = 1;   // nothing is blurred
const int FEW = 2;      // everything is about alike, or nearly sharp, and so small that few reads do
const int FINE = 4;     // alike: bilinear reads of the image
const int WIDE = 8;     // alike, and wide enough to be drawn at half resolution
const int WIDEST = 16;  // the same from a quarter of the image
const int MIXED = 32;   // several surfaces, told apart tap by tap
const int APART = 64;   // the same, with discs so wide that taps are far apart

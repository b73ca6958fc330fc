// Mixes the bits of a number: each bit of the input changes half of the output's.
// Source: the finaliser of MurmurHash3 (Appleby 2011, public domain).
// Twin:   vrcomfort.render.display.mixed.
uint mixed(uint value) {
    value ^= value >> 16;
    value *= 0x85ebca6bu;
    value ^= value >> 13;
    value *= 0xc2b2ae35u;
    return value ^ (value >> 16);
}

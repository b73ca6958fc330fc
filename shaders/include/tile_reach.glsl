// How far the discs of a tile reach. TILE: side of a tile (px); TALLEST: pixels are at most this much
// taller than wide; MARGIN_PX: how much farther others may need something; REACH: tiles that this is,
// at most. r, g of a tile are its least and greatest signed RADIUS, px of image width.
// Twin: vrcomfort/optics/tile_kinds.py.

float widest_px(vec4 tile) {
    return TALLEST * max(abs(tile.r), abs(tile.g)) + 1.0 + float(MARGIN_PX);
}

// Whether the discs of a tile come so many tiles far.
bool comes(int away, vec4 tile) {
    return float((away - 1) * TILE) <= widest_px(tile);
}

// Whether what is so many tiles away matters here: its discs come as far, or those of here do.
bool matters(int away, vec4 here, vec4 there) {
    return comes(away, here) || comes(away, there);
}

// How many tiles away anything may matter.
#ifdef WIDEST_SO_FAR
uniform sampler2D widest_so_far;  // radius (px) without limit: no disc has been wider

int reach_now() {
    float widest = widest_px(vec4(texelFetch(widest_so_far, ivec2(0), 0).r));
    return int(min(floor(widest / float(TILE)) + 1.0, float(REACH)));
}
#else
int reach_now() {
    return REACH;
}
#endif

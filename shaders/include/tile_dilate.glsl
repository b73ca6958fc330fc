// How far the discs of a tile reach. TILE: side of a tile (px); MAX_RADIUS_PX: no RADIUS is larger.
// r, g of a tile are its least and greatest signed RADIUS, px of image width.

uniform float pixel_aspect_of_eye[EYES];  // image pixels per unit, vertical / horizontal
float pixel_aspect = pixel_aspect_of_eye[EYE];

float widest_px(vec4 tile) {
    return max(pixel_aspect, 1.0) * max(abs(tile.r), abs(tile.g)) + 1.0;
}

// How many pixels there are between two tiles so many tiles apart.
float gap_px(ivec2 apart) {
    return float(TILE) * length(vec2(max(abs(apart) - 1, 0)));
}

// Whether the discs of a tile come so far.
bool reaches(float gap, vec4 tile) {
    return gap <= widest_px(tile);
}

// Whether what is so far away matters here: its discs come as far, or those of here do.
bool matters(float gap, vec4 here, vec4 there) {
    return reaches(gap, here) || reaches(gap, there);
}

// How many tiles away anything may matter.
#ifdef WIDEST
uniform eye_image widest;  // the largest radius (px) in the image, before its limit
#endif

int tiles_around() {
    float most = MAX_RADIUS_PX;
#ifdef WIDEST
    most = min(most, texel_of(widest, ivec2(0)).r);
#endif
    return int(widest_px(vec4(most)) / float(TILE)) + 1;
}

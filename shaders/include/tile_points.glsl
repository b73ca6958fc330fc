// Square points of POINT_PX on tiles, one for each vertex, in clip space of the image rounded up to
// whole tiles. Points, not triangles: those would have every block of pixels along a diagonal drawn
// twice.

// The points of the left eye come first.
int eye_of_vertex(ivec2 tiles) {
    return gl_VertexID / (tiles.x * tiles.y);
}

ivec2 tile_of_vertex(ivec2 tiles) {
    int tile = gl_VertexID % (tiles.x * tiles.y);
    return ivec2(tile % tiles.x, tile / tiles.x);
}

// What is not drawn is put outside the image.
void put_point(bool drawn, ivec2 tile, ivec2 tiles) {
    vec2 middle = (vec2(tile) + 0.5) / vec2(tiles);
    gl_PointSize = float(POINT_PX);
    gl_Position = vec4(drawn ? 2.0 * middle - 1.0 : vec2(-2.0), 0.0, 1.0);
}

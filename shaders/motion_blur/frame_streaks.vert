#version 450 core
// The streaks of a whole frame: a point for each row of tiles, all on the only pixel of a 1x1 target, which
// keeps the greatest of each component.
//
// Input:  gl_VertexID, one for each row of tiles, or with EACH_TEXEL for each tile; texels, of tile_max.frag.
// Output: greatest, of the row: x = longest half velocity, px, without the limit; y = steepness of the
//         steepest tile; z = minus the length of the shortest half velocity.
uniform sampler2D texels;

flat out vec3 greatest;

void main() {
    vec3 most = vec3(0.0, 0.0, -1e30);
    int columns = textureSize(texels, 0).x;
#ifdef EACH_TEXEL
    int row = gl_VertexID / columns, first = gl_VertexID % columns, last = first;
#else
    int row = gl_VertexID, first = 0, last = columns - 1;
#endif
    for (int x = last; x >= first; --x) {
        vec4 tile = texelFetch(texels, ivec2(x, row), 0);
        most = max(most, vec3(dot(tile.xy, tile.xy), tile.w, -tile.z));
    }
    greatest = vec3(sqrt(most.x), most.yz);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    gl_PointSize = 1.0;
}

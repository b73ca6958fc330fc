#version 450 core
// Which classes of tiles lie around each tile, so near that their programs read it.
//
// Input:  dilated (classify_tap_tiles.frag).
// Output: the same; a = all classes around, the tile's own too (vrcomfort/optics/tile_classes.py).
#include "tile_dilate.glsl"

uniform sampler2D dilated;

out vec4 tile;

void main() {
    ivec2 last = textureSize(dilated, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    tile = texelFetch(dilated, middle, 0);
    int tile_classes = 0;
    int around = tiles_around();
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 t = texelFetch(dilated, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            if (reaches(max(abs(x), abs(y)), t))
                tile_classes |= int(t.b);
        }
    tile.a = float(tile_classes);
}

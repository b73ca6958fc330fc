#version 450 core
// Which kinds of tiles lie around each tile, so near that their programs read it.
//
// Input:  reach (tap_reach.frag).
// Output: the same; a = all kinds around, the tile's own too (include/kinds.glsl).
#include "tile_reach.glsl"

uniform sampler2D reach;

out vec4 tile;

void main() {
    ivec2 last = textureSize(reach, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    tile = texelFetch(reach, middle, 0);
    int kinds = 0;
    int far = reach_now();
    for (int y = -far; y <= far; ++y)
        for (int x = -far; x <= far; ++x) {
            vec4 t = texelFetch(reach, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            if (comes(max(abs(x), abs(y)), t))
                kinds |= int(t.b);
        }
    tile.a = float(kinds);
}

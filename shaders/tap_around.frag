#version 450 core
// Which kinds of tiles lie around each tile, within AROUND: their programs may read it.
//
// Input:  reach (tap_reach.frag).
// Output: the same; a = all kinds around, the tile's own too (include/tap_kinds.glsl).
uniform sampler2D reach;

out vec4 tile;

void main() {
    ivec2 last = textureSize(reach, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    tile = texelFetch(reach, middle, 0);
    int kinds = 0;
    for (int y = -AROUND; y <= AROUND; ++y)
        for (int x = -AROUND; x <= AROUND; ++x)
            kinds |= int(texelFetch(reach, clamp(middle + ivec2(x, y), ivec2(0), last), 0).b);
    tile.a = float(kinds);
}

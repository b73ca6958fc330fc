#version 450 core
// Lets every tile know what may reach it: the same summary over its neighbours within REACH tiles.
//
// Input:  tiles of defocus_tiles.frag. Output: the same four numbers over the neighbourhood;
//         b over the next tiles only.
uniform sampler2D tiles;

out vec4 reach;

void main() {
    ivec2 last = textureSize(tiles, 0) - 1;
    reach = vec4(1e4, -1e4, 0.0, 1e4);
    for (int y = -REACH; y <= REACH; ++y)
        for (int x = -REACH; x <= REACH; ++x) {
            vec4 t = texelFetch(tiles, clamp(ivec2(gl_FragCoord.xy) + ivec2(x, y), ivec2(0), last), 0);
            if (max(abs(x), abs(y)) > 1)
                t.b = 0.0;  // small discs reach no further
            reach = vec4(min(reach.r, t.r), max(reach.gb, t.gb), min(reach.a, t.a));
        }
}

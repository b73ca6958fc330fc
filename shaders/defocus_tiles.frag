#version 450 core
// Sums up tiles of pixels, one axis at a time: a column of TILE pixels, then a row of columns.
//
// Input:  x-pass (AXIS 0): points of defocus.frag; y-pass (AXIS 1): the result of the x-pass.
// Output: r = least and g = greatest signed CoC RADIUS (px) in the tile; b = greatest RADIUS that
//         is small (above half a pixel, within SMALL_PX), or 0: those need the dense loop;
//         a = least signed RADIUS of those that are wider, or 1e4.
uniform sampler2D source;

out vec4 tile;

void main() {
    ivec2 last = textureSize(source, 0) - 1;
    ivec2 step_px = AXIS == 0 ? ivec2(1, 0) : ivec2(0, 1);
    ivec2 first = ivec2(gl_FragCoord.xy) * (1 + step_px * (TILE - 1));
    tile = vec4(1e4, -1e4, 0.0, 1e4);
    for (int i = 0; i < TILE; ++i) {
        vec4 s = texelFetch(source, min(first + i * step_px, last), 0);
#if AXIS == 0
        bool small = abs(s.a) > 0.5 && abs(s.a) <= SMALL_PX;
        s = vec4(s.aa, small ? abs(s.a) : 0.0, abs(s.a) > SMALL_PX ? s.a : 1e4);
#endif
        tile = vec4(min(tile.r, s.r), max(tile.gb, s.gb), min(tile.a, s.a));
    }
}

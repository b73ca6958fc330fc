#version 450 core
// Blurs a view through a part of a lens: light that two pixels trade, each the other's disc.
//
// Input:  colour_and_coc (colour and signed CoC RADIUS, px of image width, negative in front of the focus),
//         reach (least and greatest radius near this tile), discs (of every radius on the pixel
//         grid: grid_discs).
// Output: the blurred image, linear HDR, full resolution.
//
// Where the surfaces of two pixels meet, the nearer one's disc says how soft their edge is, on both
// of its sides: so that is the disc over which these two trade light. What one pixel gives is what
// the other gets: light is kept, and a pixel of an edge, whose colour is of both surfaces and whose
// depth is of one, does not count for either. Only where views are many: what one of them hides,
// the others see. Twin: tests/oracles/small_discs.py.
#include "coc.glsl"

uniform sampler2D colour_and_coc;
uniform sampler2D dilated;
uniform vec2 discs[DISCS];   // grid radius (px), weight of a whole pixel; PER_PX for each px of radius
uniform float pixel_aspect;  // image pixels per unit, vertical / horizontal

out vec4 blurred;

// What two pixels so far apart trade of their light over a disc: nothing at radius 0.
float share(float away, float radius) {
    float at = min(radius * PER_PX, float(DISCS) - 1.001);
    int i = int(at);
    vec2 disc = mix(discs[i], discs[i + 1], at - float(i));
    return disc_weight(max(away, 1.0), disc.x, 1.0) * disc.y;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(colour_and_coc, 0) - 1;
    vec4 p = texelFetch(colour_and_coc, pixel, 0);
    vec4 tile = texelFetch(dilated, pixel / TILE, 0);
    float reach_px = max(-tile.r, tile.g);
    int cells = int(reach_px + 1.0);
    int rows = reach_px > 0.0 ? int(reach_px * pixel_aspect + 1.0) : 0;
    vec4 traded = vec4(0.0);  // rgb to get, share of p to give
    for (int y = -rows; y <= rows; ++y)
        for (int x = -cells; x <= cells; ++x) {
            vec4 q = texelFetch(colour_and_coc, clamp(pixel + ivec2(x, y), ivec2(0), last), 0);
            float away = length(vec2(float(x), float(y) / pixel_aspect));
            bool other = x != 0 || y != 0;
            float part = other ? share(away, abs(min(p.a, q.a))) / pixel_aspect : 0.0;
            traded += part * vec4(q.rgb - p.rgb, 1.0);
        }
    blurred = vec4(clamp(p.rgb + traded.rgb / max(traded.a, 1.0), 0.0, 65504.0), 1.0);
}

#version 450 core
// Near things, drawn over the picture of what lies behind them.
//
// Input:  near (near_gather.frag), at half resolution; drawn on tiles of class NEAR.
// Output: rgb and opacity, premultiplied, to be blended.
//
// Between texels. Where one is brighter than white, the mean of a texel's pixels stays what the texel is, so that
// a lamp's disc has no rim beyond its own.
#include "eyes.glsl"
uniform eye_image near;

out vec4 over;

ivec2 last_texel = size_of(near) - 1;
ivec2 pixel = ivec2(gl_FragCoord.xy);

vec4 texel_at(int x, int y) {
    return texel_of(near, clamp(pixel / 2 + ivec2(x, y), ivec2(0), last_texel));
}

void main() {
    ivec2 side = 2 * (pixel & 1) - 1;
    vec4 own = texel_at(0, 0);
    vec4 others[3] = vec4[3](texel_at(side.x, 0), texel_at(0, side.y), texel_at(side.x, side.y));
    over = 0.75 * 0.75 * own + 0.75 * 0.25 * (others[0] + others[1]) + 0.25 * 0.25 * others[2];  // bilinear
    vec4 least = min(min(own, others[0]), min(others[1], others[2]));
    vec4 most = max(max(own, others[0]), max(others[1], others[2]));
    float part = clamp(max(max(most.r, most.g), most.b) - 1.0, 0.0, 1.0);
    int around = part > 0.0 ? 1 : -1;
    vec4 mean = vec4(0.0);  // over the texel, of what is bilinear
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x)
            mean += (x == 0 ? 0.75 : 0.5 * 0.25) * (y == 0 ? 0.75 : 0.5 * 0.25) * texel_at(x, y);
    over = part > 0.0 ? clamp(over + part * (own - mean), least, most) : over;
}

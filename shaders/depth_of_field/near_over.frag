#version 450 core
// Near things, drawn over the picture of what lies behind them.
//
// Input:  near (near_gather.frag), at half resolution; drawn on tiles of class NEAR.
// Output: rgb and opacity, premultiplied, to be blended.
uniform sampler2D near;
uniform vec2 size_px;

out vec4 over;

void main() {
    over = textureLod(near, gl_FragCoord.xy / size_px, 0.0);
}

#version 450 core
// Half of the points for gathers whose taps lie more than a pixel apart, without mixing surfaces.
//
// Input:  colour_and_coc of colour_and_coc.frag, or a half of them (signed CoC RADIUS, px of full width).
// Output: the same at half size (rounded up); texel t covers texels 2t and 2t + 1 of the input.
//
// The radius is that of one of the four, so that areas keep their share; the colour is the mean of
// those that are about as blurred. A sharp point never gets into a blurred one.
uniform sampler2D colour_and_coc;

out vec4 point;

void main() {
    ivec2 last = textureSize(colour_and_coc, 0) - 1;
    ivec2 first = ivec2(gl_FragCoord.xy) * 2;
    point = texelFetch(colour_and_coc, first, 0);
    float weight = 1.0;
    for (int i = 1; i < 4; ++i) {
        vec4 q = texelFetch(colour_and_coc, min(first + ivec2(i & 1, i >> 1), last), 0);
        float like = max(1.0 - abs(q.a - point.a), 0.0);
        point.rgb += like * q.rgb;
        weight += like;
    }
    point.rgb = min(point.rgb / weight, 65504.0);
}

#version 450 core
// Half resolution for the widest discs, where taps lie further apart than two pixels.
//
// Input:  colour_and_coc of colour_and_coc.frag. Output: rgb, a as there, at half size (rounded up).
//
// Texel t stands for pixel 2t: its radius is that pixel's, so that areas keep their share, and its
// colour is a tent over the 3x3 pixels around it that are about as blurred. A sharp pixel never
// gets into a blurred one, which is what keeps sharp silhouettes from bleeding.
uniform sampler2D colour_and_coc;

out vec4 point;

void main() {
    ivec2 last = textureSize(colour_and_coc, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy) * 2;
    float radius = texelFetch(colour_and_coc, middle, 0).a;
    vec4 sum = vec4(0.0);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            vec4 q = texelFetch(colour_and_coc, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            float tent = float((2 - abs(x)) * (2 - abs(y)));
            sum += tent * max(1.0 - abs(q.a - radius), 0.0) * vec4(q.rgb, 1.0);
        }
    point = vec4(sum.rgb / sum.a, radius);  // the middle itself has weight 4
}

#version 450 core
// Down-samples by two: the mean of 2 x 2 texels, with zeros beyond an odd edge.
//
// Input:  source. Output: half its size, rounded up. Repeated down to one texel it holds the sums of
// weighted values and of weights over the same number, so that their ratio is exact for any size.
// Source: Hillaire et al. 2008, Eq. 3.
uniform sampler2D source;
out vec4 mean;

void main() {
    ivec2 size = textureSize(source, 0);
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    vec4 sum = vec4(0.0);
    for (int y = first.y; y < min(first.y + 2, size.y); ++y)
        for (int x = first.x; x < min(first.x + 2, size.x); ++x)
            sum += texelFetch(source, ivec2(x, y), 0);
    mean = 0.25 * sum;
}

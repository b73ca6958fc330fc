#version 450 core
// The mean colour of the part of an image that a texel of the target covers.
//
// Input:  image (linear HDR).
// Output: the mean; each texel of the image counts in one texel of the target.
uniform sampler2D image;
uniform ivec2 target_px;

out vec4 mean;

void main() {
    ivec2 size_px = textureSize(image, 0);
    ivec2 texel = ivec2(gl_FragCoord.xy);
    ivec2 first = texel * size_px / target_px;
    ivec2 end = max((texel + 1) * size_px / target_px, first + 1);
    vec3 sum = vec3(0.0);
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            sum += texelFetch(image, ivec2(x, y), 0).rgb;
        }
    }
    ivec2 counted = end - first;
    mean = vec4(sum / float(counted.x * counted.y), 1.0);
}

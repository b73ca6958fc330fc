#version 450 core
// Half of the image: the mean of 2 x 2 pixels, radius too. For discs of one surface.
//
// Input:  colour_and_coc (colour_and_coc.frag).
// Output: rgb, RADIUS (px of image width, negative in front of the focus).
uniform sampler2D colour_and_coc;

out vec4 half_resolution;

void main() {
    ivec2 last = textureSize(colour_and_coc, 0) - 1;
    ivec2 first = 2 * ivec2(gl_FragCoord.xy), second = min(first + 1, last);
    half_resolution = 0.25 * (texelFetch(colour_and_coc, first, 0) + texelFetch(colour_and_coc, second, 0)
                    + texelFetch(colour_and_coc, ivec2(second.x, first.y), 0)
                    + texelFetch(colour_and_coc, ivec2(first.x, second.y), 0));
}

#version 450 core
// Tiles in which nothing is blurred: as they are, bit for bit.
//
// Input:  colour_and_coc (colour_and_coc.frag).
// Output: the image, linear HDR, full resolution.
uniform sampler2D colour_and_coc;

out vec4 blurred;

void main() {
    blurred = vec4(texelFetch(colour_and_coc, ivec2(gl_FragCoord.xy), 0).rgb, 1.0);
}

#version 450 core
// Half of the image: the mean of 2 x 2 pixels, radius too. For discs of one surface.
//
// Input:  colour_and_coc (colour_and_coc.frag), read bilinearly.
// Output: rgb, RADIUS (px of image width, negative in front of the focus).
uniform sampler2D colour_and_coc;

out vec4 half_resolution;

void main() {
    vec2 at = 2.0 * gl_FragCoord.xy / vec2(textureSize(colour_and_coc, 0));
    half_resolution = textureLod(colour_and_coc, at, 0.0);
}

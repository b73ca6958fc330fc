#version 450 core
// Where nothing is blurred: the image, bit by bit.
//
// Input: colour (linear HDR). Output: the same.
uniform sampler2D colour;

out vec4 blurred;

void main() {
    blurred = texelFetch(colour, ivec2(gl_FragCoord.xy), 0);
}

#version 450 core
// Shows a picture as it is.
//
// Input:  picture, sRGB-encoded with straight alpha, lower row first.
// Output: the same colours, not decoded: windows take encoded colours.
layout(binding = 0) uniform sampler2D picture;
in vec2 uv;
out vec4 encoded;

void main() {
    encoded = texture(picture, uv);
}

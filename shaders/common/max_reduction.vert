#version 450 core
// One point for each texel of a texture, all on the only pixel of a 1x1 target: with blending set
// to the maximum, the target remembers the largest value of all texels and all frames.
//
// Input:  gl_VertexID counts the texels; the length of their VALUE (xy, z …) counts. Output: value.
uniform sampler2D texels;

flat out float value;

void main() {
    int width = textureSize(texels, 0).x;
    value = length(texelFetch(texels, ivec2(gl_VertexID % width, gl_VertexID / width), 0).VALUE);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    gl_PointSize = 1.0;
}

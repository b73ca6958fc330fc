#version 450 core
// One point for each texel of a texture, all on the only pixel of a 1x1 target: with blending set
// to the maximum, the target remembers the largest value of all texels.
//
// Input:  gl_VertexID counts the texels; their VALUE (x, z …) counts. Output: greatest, x = value.
uniform sampler2D texels;

flat out vec3 greatest;

void main() {
    int width = textureSize(texels, 0).x;
    float value = length(texelFetch(texels, ivec2(gl_VertexID % width, gl_VertexID / width), 0).VALUE);
    greatest = vec3(value, 0.0, 0.0);
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
    gl_PointSize = 1.0;
}

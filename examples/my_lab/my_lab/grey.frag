#version 450 core
// Mixes each pixel with its luminance (Rec. 709, linear).
uniform sampler2D image;
uniform float amount;

out vec4 grey;

void main() {
    vec4 colour = texelFetch(image, ivec2(gl_FragCoord.xy), 0);
    float luminance = dot(colour.rgb, vec3(0.2126, 0.7152, 0.0722));
    grey = vec4(mix(colour.rgb, vec3(luminance), amount), colour.a);
}

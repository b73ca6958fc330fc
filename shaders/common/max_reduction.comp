#version 450 core
// The greatest length of all texels of a texture, and of all of the frames so far: one work group.
//
// Input:  texels, of which the length of VALUE (xy, z ...) counts; what is not a number counts as 0.
// Output: greatest, of this texture; greatest_of_all, that or what stands there, if that is more. Both 1x1.
// Blur:   none.
// Source: ours. Positive floats have the order of their bits, so that integers find the maximum.
#include "summed_texels.glsl"
layout(local_size_x = 1024) in;  // as many as every OpenGL 4.5 has

uniform sampler2D texels;
layout(r32f, binding = 0) uniform writeonly image2D greatest;
layout(r32f, binding = 1) uniform image2D greatest_of_all;

shared uint most_bits;

void main() {
    if (gl_LocalInvocationIndex == 0u)
        most_bits = 0u;
    barrier();
    ivec2 size = textureSize(texels, 0);
    float most = 0.0;
    int last = texels_of(size);
    for (int i = int(gl_LocalInvocationIndex); i < last; i += int(gl_WorkGroupSize.x)) {
        float value = length(texelFetch(texels, texel_at(i, size), 0).VALUE);
        most = value > most ? value : most;
    }
    atomicMax(most_bits, floatBitsToUint(most));
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        float found = uintBitsToFloat(most_bits);
        imageStore(greatest, ivec2(0), vec4(found));
        float before = imageLoad(greatest_of_all, ivec2(0)).x;
        imageStore(greatest_of_all, ivec2(0), vec4(max(before, found)));
    }
}

#version 430

// Hashes an image as a display gets it: two sums over all pixels of a mix of place and colour, so
// that the order in which pixels are added does not matter and every GPU gives the same.
// Input:  `image`, RGBA8, sRGB-encoded, rows from the bottom; alpha is not hashed.
// Output: adds to `sums[first]` and `sums[first + 1]`; each work group is one row.
// Blur:   none.
// Twin:   vrcomfort.render.display.image_hash.
#include "mixed.glsl"

layout(local_size_x = 128) in;

layout(std430, binding = 0) buffer Sums { uint sums[]; };

uniform sampler2D image;
uniform int first;

shared uint of_row[2];

void main() {
    if (gl_LocalInvocationIndex < 2u) {
        of_row[gl_LocalInvocationIndex] = 0u;
    }
    barrier();
    ivec2 size = textureSize(image, 0);
    int row = int(gl_WorkGroupID.x);
    uvec2 sum = uvec2(0u);
    for (int x = int(gl_LocalInvocationIndex); x < size.x; x += int(gl_WorkGroupSize.x)) {
        uvec3 rgb = uvec3(round(texelFetch(image, ivec2(x, size.y - 1 - row), 0).rgb * 255.0));
        uint colour = rgb.r | rgb.g << 8 | rgb.b << 16;
        uint place = 2u * uint(row * size.x + x);
        sum += uvec2(mixed(colour ^ mixed(place)), mixed(colour ^ mixed(place + 1u)));
    }
    atomicAdd(of_row[0], sum.x);
    atomicAdd(of_row[1], sum.y);
    barrier();
    if (gl_LocalInvocationIndex < 2u) {
        atomicAdd(sums[first + int(gl_LocalInvocationIndex)], of_row[gl_LocalInvocationIndex]);
    }
}

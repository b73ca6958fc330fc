// The texels of a texture that are summed up: all, or with LISTED those that are listed.
#ifdef LISTED
layout(std430, binding = 0) readonly buffer Listed {
    uint count;
    uint listed[];  // row by row
};
#endif

int texels_of(ivec2 size) {
#ifdef LISTED
    return int(count);
#else
    return size.x * size.y;
#endif
}

ivec2 texel_at(int index, ivec2 size) {
#ifdef LISTED
    index = int(listed[index]);
#endif
    return ivec2(index % size.x, index / size.x);
}

// The texels of a texture that are summed up: all, or with LISTED those that are listed.
#ifdef LISTED
layout(std430, binding = 0) readonly buffer Listed {
    uint counts[EYES];
    uint listed[];  // row by row, those of the left eye first
};
#endif

int texels_of(ivec2 size) {
#ifdef LISTED
    return int(counts[EYE]);
#else
    return size.x * size.y;
#endif
}

ivec2 texel_at(int index, ivec2 size) {
#ifdef LISTED
    index = int(listed[(EYE > 0 ? int(counts[0]) : 0) + index]);
#endif
    return ivec2(index % size.x, index / size.x);
}

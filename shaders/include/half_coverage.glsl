// Part of a texel of half an image that its surface covers, in the last bits of its RADIUS, which is a half float.
//
// The last bit says whether a pixel is blurred little; the next three are a code: 1, 3/4, 1/2, 1/4, 1/8 … 1/64.
// Six bits are left for the RADIUS: steps of 1/64.

const uint CODES = 7u;

float coverage_of_code(uint code) {
    return code < 2u ? 1.0 - 0.25 * float(code) : uintBitsToFloat((128u - code) << 23);  // 2^(1 - code)
}

uint coverage_code(float coverage) {
    return coverage > 0.5 ? uint(4.0 * (1.0 - coverage) + 0.5)
                          : min(uint(1.5 - log2(max(coverage, 1e-4))), CODES);
}

// A float that was a half float has its last bit in bit 13.
float coverage_of(float radius) {
    return coverage_of_code(floatBitsToUint(radius) >> 14 & CODES);
}

bool is_small(float radius) {
    return (floatBitsToUint(radius) >> 13 & 1u) != 0u;
}

float with_coverage(float radius, uint code, bool small) {
    const float LEAST_PX = 1e-3;  // far from half floats without a leading 1, whose bits move
    float kept = abs(radius) < LEAST_PX ? LEAST_PX : radius;
    uint bits = packHalf2x16(vec2(kept, 0.0)) + 8u & ~15u;
    return unpackHalf2x16(bits | code << 1 | (small ? 1u : 0u)).x;
}

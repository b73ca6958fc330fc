// Part of a pixel that the surface whose RADIUS it has covers, in the last two bits of that half float.
//
// A pixel on a silhouette has the light of both surfaces. As quarters of the pixel are covered, so the bits are: 0 is all
// of it. Eight bits are left for the RADIUS: steps of 1/512. WITH_COVERAGE: scene/resolve.frag
// has written them.

float coverage_of(float radius) {
#ifdef WITH_COVERAGE
    // A float that was a half float has its last bit in bit 13.
    return 1.0 - 0.25 * float(floatBitsToUint(radius) >> 13 & 3u);
#else
    return 1.0;
#endif
}

float with_coverage(float radius, float coverage) {
    const float LEAST_PX = 1e-3;  // far from half floats without a leading 1, whose bits move
    float kept = abs(radius) < LEAST_PX ? (coverage < 1.0 ? LEAST_PX : 0.0) : radius;
    uint bits = packHalf2x16(vec2(kept, 0.0)) + 2u & ~3u;
    return unpackHalf2x16(bits | min(uint(4.0 * (1.0 - coverage) + 0.5), 3u)).x;
}

// Two surfaces in one texel of 2^L pixels: the foreground, how much of the texel it covers, and what
// is behind it. Eight numbers in the 128 bits of a texel.
//
// Radii are those of circles of confusion in pixels of image width, negative in front of the focus. Twin:
// tests/oracles/layers.py. Include after coc.glsl.

struct Layers {
    vec4 front;      // rgb, signed radius (px); nothing where coverage is 0
    vec4 back;       // the same
    float coverage;  // of the foreground, 0 to 1
};

// Coverage is in sixteenths: the low bits of the foreground's radius, whose step is then 1/64 of it.
uvec4 pack_layers(Layers texel) {
    uint sixteenths = uint(clamp(texel.coverage * 16.0 + 0.5, 0.0, 15.0));
    uint last = (packHalf2x16(vec2(texel.front.b, texel.front.a)) & 0xFFF0FFFFu) | (sixteenths << 16);
    return uvec4(packHalf2x16(texel.back.rg), packHalf2x16(texel.back.ba),
                 packHalf2x16(texel.front.rg), last);
}

Layers unpack_layers(uvec4 bits) {
    vec4 back = vec4(unpackHalf2x16(bits.x), unpackHalf2x16(bits.y));
    vec4 front = vec4(unpackHalf2x16(bits.z), unpackHalf2x16(bits.w & 0xFFF0FFFFu));
    return Layers(front, back, float((bits.w >> 16) & 15u) / 16.0);
}

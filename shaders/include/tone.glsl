// Tone curve and display encoding. Twin: vrcomfort/optics/tone.py, whose COMPRESSION_START and
// DESATURATION are defines here.

// Keeps hue and colour up to 0.8 - F90 offset, then presses highlights into [0.8, 1) and fades
// them to white. Source: Khronos PBR Neutral, KhronosGroup/ToneMapping (2024).
vec3 pbr_neutral(vec3 color) {
    float least = min(color.r, min(color.g, color.b));
    float offset = least < 0.08 ? least - 6.25 * least * least : 0.04;
    color -= offset;
    float peak = max(color.r, max(color.g, color.b));
    if (peak < COMPRESSION_START) return color;
    const float D = 1.0 - COMPRESSION_START;
    float pressed = 1.0 - D * D / (peak + D - COMPRESSION_START);
    color *= pressed / peak;
    float gray = 1.0 - 1.0 / (DESATURATION * (peak - pressed) + 1.0);
    return mix(color, vec3(pressed), gray);
}

// Source: IEC 61966-2-1.
vec3 srgb_encoded(vec3 linear) {
    vec3 color = clamp(linear, 0.0, 1.0);
    vec3 curve = 1.055 * pow(color, vec3(1.0 / 2.4)) - 0.055;
    return mix(curve, 12.92 * color, lessThanEqual(color, vec3(0.0031308)));
}

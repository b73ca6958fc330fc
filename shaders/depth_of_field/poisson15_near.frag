#version 450 core
// Fifteen taps in a circle of confusion that a blurred foreground widens beyond its own silhouette edge.
//
// Input:  colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width, negative in
//         front of the
//         focus), near_mean of poisson15_near_mean.frag. Colours and means are read bilinearly.
// Output: the blurred image, linear HDR, full resolution.
//
//   own  ___          mean ..__          2 max(own, mean) - own ___
//           |                  ''..                                ''..
//           |___                   ''..                                ''.   joins at the outline
//
// The far circle is as it is; the wider of the two counts. Every tap weighs the same: a sharp foreground
// leaks, and a background beside a blurred foreground is blurred with it (the paper says so of both).
// NumPy twin: tests/oracles/poisson_taps.py. Mantiuk et al. 2011, Eq. 2 and section 4.
uniform sampler2D colour_and_coc;
uniform sampler2D near_mean;
uniform vec2 offsets[TAPS];   // in a disc of radius 0.5
uniform float pixel_aspect;   // image pixels per unit, vertical / horizontal
uniform float max_radius_px;

out vec4 blurred;

float blur_radius_px(float signed_px) {
    float own = max(-signed_px, 0.0);
    vec2 cells = vec2(textureSize(near_mean, 0));
    float mean = textureLod(near_mean, gl_FragCoord.xy / float(CELL) / cells, 0.0).r;
    return min(max(2.0 * max(own, mean) - own, signed_px), max_radius_px);
}

void main() {
    vec2 size_px = vec2(textureSize(colour_and_coc, 0));
    vec4 p = texelFetch(colour_and_coc, ivec2(gl_FragCoord.xy), 0);
    float radius_px = blur_radius_px(p.a);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < TAPS; ++i) {
        vec2 away_px = 2.0 * radius_px * offsets[i] * vec2(1.0, pixel_aspect);
        sum += textureLod(colour_and_coc, (gl_FragCoord.xy + away_px) / size_px, 0.0).rgb;
    }
    // Fifteen times the same over fifteen may be off by one bit.
    blurred = vec4(radius_px > 0.0 ? min(sum / float(TAPS), HALF_MAX) : p.rgb, 1.0);
}

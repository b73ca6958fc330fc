#version 450 core
// A coarser level of the surfaces in the image: each texel keeps two of them apart.
//
// Input:  colour_and_coc (colour_and_coc.frag), or FROM_LAYERS finer: a level as fine again
//         (signed CoC RADIUS, px of image width, negative in front of the focus).
// Output: texel t holds texels 2t and 2t + 1 of the input (include/layers.glsl).
//
// What is nearer than the farthest surface by the margin that tells surfaces apart is the foreground.
#include "eyes.glsl"
#include "coc.glsl"
#include "finite.glsl"
#include "layers.glsl"

#ifdef FROM_LAYERS
uniform ueye_image finer;
#else
uniform eye_image finer;
#endif

out uvec4 layers;

vec4 surfaces[8];  // rgb, signed radius
float parts[8];

void read(ivec2 first, ivec2 last) {
    for (int i = 0; i < 4; ++i) {
        ivec2 at = min(first + ivec2(i & 1, i >> 1), last);
#ifdef FROM_LAYERS
        Layers texel = unpack_layers(texel_of(finer, at));
        surfaces[i] = texel.back;
        surfaces[i + 4] = texel.front;
        parts[i] = 1.0 - texel.coverage;
        parts[i + 4] = texel.coverage;
#else
        surfaces[i] = texel_of(finer, at);
        parts[i] = 1.0;
#endif
    }
}

#ifdef FROM_LAYERS
const int SURFACES = 8;
#else
const int SURFACES = 4;
#endif

// What is nearer than the farthest surface by so many margins is the foreground.
const float BORDER_MARGINS = 1.5;  // Fitted: python -m bench --only fitted

void main() {
    read(2 * ivec2(gl_FragCoord.xy), size_of(finer) - 1);
    float farthest = -1e4, nearest = 1e4;
    for (int i = 0; i < SURFACES; ++i) {
        farthest = parts[i] > 0.0 ? max(farthest, surfaces[i].a) : farthest;
        nearest = parts[i] > 0.0 ? min(nearest, surfaces[i].a) : nearest;
    }
    float border = min(farthest - BORDER_MARGINS * margin_px(farthest), 0.5 * (nearest + farthest));
    vec4 front = vec4(0.0), back = vec4(0.0);
    float in_front = 0.0;
    for (int i = 0; i < SURFACES; ++i) {
        float part = surfaces[i].a < border ? parts[i] : 0.0;
        front += part * surfaces[i];
        back += (parts[i] - part) * surfaces[i];
        in_front += part;
    }
    back *= UP / max(4.0 - in_front, 1e-3);
    layers = pack_layers(Layers(UP * front / max(in_front, 1e-3), back, 0.25 * in_front));
}

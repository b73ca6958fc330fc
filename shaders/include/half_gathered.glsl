// Reads of half_gather.frag's result between four texels, of which some are complete, and some only cover.
//
// Hardware would mix their light, which means different things. Include after eyes.glsl.

uniform eye_image gathered;

struct Gathered {
    vec4 complete;  // light of the texels that are complete; a = opacity of what covers them
    vec4 cover;     // light of what covers, and its opacity, which is that of all four
    float part;     // of the four that is complete
};

Gathered gathered_at(vec2 pixel) {
    vec2 place = 0.5 * pixel - 0.5;
    ivec2 first = ivec2(floor(place)), last = size_of(gathered) - 1;
    vec2 beside = place - vec2(first);
    vec4 complete = vec4(0.0), cover = vec4(0.0);
    float part = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec4 t = texel_of(gathered, clamp(first + step, ivec2(0), last));
        vec2 share = mix(1.0 - beside, beside, vec2(step));
        float weight = share.x * share.y;
        bool is_complete = t.a >= 0.0;
        complete += is_complete ? weight * t : vec4(0.0);
        cover += is_complete ? vec4(0.0) : weight * vec4(t.rgb, -1.0 - t.a);
        part += is_complete ? weight : 0.0;
    }
    complete /= max(part, 1e-4);
    vec3 light = cover.a > 1e-3 ? cover.rgb / cover.a : complete.rgb;
    return Gathered(complete, vec4(light, cover.a + part * complete.a), part);
}

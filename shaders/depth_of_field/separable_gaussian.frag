#version 450 core
// A Gaussian along one axis, as wide as the pixel's own disc, at half resolution.
//
// Input:  half_image of half_resolution.frag (signed CoC RADIUS, px of the whole image), or the result
//         of the other axis; read bilinearly.
// Output: rgb; a = the radius, unchanged.
//
// A disc of radius r has the variance r^2 / 4 along each axis: sigma = r / 2. Two texels are one read,
// at the place between them that weighs them right. No depth is compared.
// NumPy twin: tests/oracles/half_resolution.py. As the Gaussian depth of field of Bevy.
uniform sampler2D half_image;
uniform vec2 axis;           // (1, 0) or (0, pixel_aspect)

out vec4 blurred;

const float REACH = 3.0;  // in sigmas

void main() {
    vec2 size = vec2(textureSize(half_image, 0));
    vec4 p = texelFetch(half_image, ivec2(gl_FragCoord.xy), 0);
    float sigma = 0.25 * abs(p.a) * (axis.x + axis.y);  // in texels of this axis
    vec2 step_texels = sign(axis);
    int texels = int(ceil(REACH * sigma));
    vec4 sum = vec4(p.rgb, 1.0);
    for (int i = 1; i <= texels; i += 2) {
        float first = exp(-0.5 * float(i * i) / (sigma * sigma));
        float second = exp(-0.5 * float((i + 1) * (i + 1)) / (sigma * sigma));
        float weight = first + second;
        if (weight <= 0.0)
            break;
        vec2 away = (float(i) + second / weight) * step_texels;
        vec3 c = textureLod(half_image, (gl_FragCoord.xy + away) / size, 0.0).rgb;
        c += textureLod(half_image, (gl_FragCoord.xy - away) / size, 0.0).rgb;
        sum += weight * vec4(c, 2.0);
    }
    blurred = vec4(min(sum.rgb / sum.a, 65504.0), p.a);
}

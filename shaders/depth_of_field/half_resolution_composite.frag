#version 450 core
// Puts what was blurred at half resolution over the sharp image.
//
// Input:  colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width, negative in
//         front of the focus), half_image (a = opacity of the foreground; read bilinearly).
// Output: the blurred image, linear HDR, full resolution.
//
// FAR_FROM_PX, FAR_TO_PX: between these radii of its own a pixel goes from sharp to blurred.
// OWN_RADIUS: on either side of the focus, and no opacity counts.
// FRONT: the foreground is an image of its own, half_front, with its opacity in a.
// NumPy twin: tests/oracles/half_resolution.py.
uniform sampler2D colour_and_coc;
uniform sampler2D half_image;
#ifdef FRONT
uniform sampler2D half_front;
#endif

out vec4 blurred;

void main() {
    vec4 p = texelFetch(colour_and_coc, ivec2(gl_FragCoord.xy), 0);
    vec2 place = gl_FragCoord.xy / (2.0 * vec2(textureSize(half_image, 0)));
    vec4 soft = textureLod(half_image, place, 0.0);
#ifdef OWN_RADIUS
    float alpha = smoothstep(FAR_FROM_PX, FAR_TO_PX, abs(p.a));
#else
    float alpha = smoothstep(FAR_FROM_PX, FAR_TO_PX, p.a);
#ifndef FRONT
    alpha += soft.a - alpha * soft.a;
#endif
#endif
    vec3 colour = alpha > 0.0 ? mix(p.rgb, soft.rgb, alpha) : p.rgb;
#ifdef FRONT
    vec4 front = textureLod(half_front, place, 0.0);
    colour = front.a > 0.0 ? mix(colour, front.rgb, front.a) : colour;
#endif
    blurred = vec4(min(colour, 65504.0), 1.0);
}

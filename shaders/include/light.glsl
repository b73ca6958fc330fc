// Light of a scene: sun with shadow, sky above and ground below, lamps, air.
//
// Filled by render/lighting.py by these names. Directions and positions are "relative" (view.glsl).

layout(std140, binding = 1) uniform Light {
    vec4 sun_direction;         // xyz: unit vector to the sun
    vec4 sun_irradiance;        // rgb: on a surface that faces the sun
    vec4 sky_zenith;            // rgb: radiance
    vec4 sky_horizon;           // rgb: radiance
    vec4 ground;                // rgb: radiance
    vec4 fog;                   // rgb: radiance of infinitely much air, a: extinction per metre
    vec4 clouds;                // x: share of the sky
    mat4 shadow_from_relative;  // to [0, 1]^3: texture coordinate and depth (1 = next to the sun)
    vec4 shadow_bias;           // x: texel (of 1), y: offset along the normal m, z: depth
    vec4 lamp_position[16];     // xyz: relative, w: range m; of infinitely far ones xyz: to them, w: 0
    vec4 lamp_intensity[16];    // rgb: irradiance at 1 m, of infinitely far ones everywhere; a: see cone
    vec4 lamp_direction[16];    // xyz: where a spot light shines, w: see cone
};

// Share of a spot light that reaches a place seen from it along -l; no cone: w = 0, offset = 1.
// Source: KHR_lights_punctual, "Inner and Outer Cone Angles".
float cone(vec3 l, vec4 direction, float offset) {
    float inside = clamp(offset - dot(l, direction.xyz) * direction.w, 0.0, 1.0);
    return inside * inside;
}

// Irradiance of a lamp at a distance: inverse square, and zero at the range without an edge.
// Source: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013, eq. 9.
float lamp_falloff(float distance_m, float range_m) {
    float x = distance_m / range_m;
    float window = clamp(1.0 - x * x * x * x, 0.0, 1.0);
    return window * window / max(distance_m * distance_m, 1e-4);
}

// Colour of a surface seen through air; radiance of the air itself comes from the sky's horizon.
vec3 through_air(vec3 radiance, float distance_m) {
    return mix(fog.rgb, radiance, exp(-fog.a * distance_m));
}

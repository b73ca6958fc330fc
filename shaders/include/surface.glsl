// Reflection of a surface.
//
// Source: Khronos glTF 2.0, appendix B; Filament's formulation of GGX
// (https://google.github.io/filament/Filament.md.html, section 4).

const float INV_PI = 0.318309886;

// Specular reflection of light from l: D * V * F, times n·l left to the caller.
vec3 specular(vec3 n, vec3 v, vec3 l, vec3 f0, float alpha) {
    vec3 h = normalize(v + l);
    float n_l = max(dot(n, l), 0.0);
    float n_v = max(dot(n, v), 1e-3);
    float n_h = max(dot(n, h), 0.0);
    float a2 = alpha * alpha;
    float d = n_h * n_h * (a2 - 1.0) + 1.0;
    float distribution = a2 * INV_PI / (d * d);
    // Hammon's approximation of the height-correlated Smith term.
    float visibility = 0.5 / mix(2.0 * n_l * n_v, n_l + n_v, alpha);
    float grazing = 1.0 - clamp(dot(v, h), 0.0, 1.0);
    float g2 = grazing * grazing;
    return (f0 + (1.0 - f0) * (g2 * g2 * grazing)) * (distribution * visibility);
}

// Reflectance for light from everywhere. Source: Karis, "Physically based shading on mobile" (2014).
vec3 ambient_reflectance(vec3 f0, float roughness, float n_v) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a004 = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
    return f0 * ab.x + ab.y;
}

// The twin of `bsdf/diffuse.rs` and `bsdf/sheen.rs`.

struct OrenNayar {
    colour: vec3<f32>,
    roughness: f32,
    scale: f32,
    several: vec3<f32>,
    lost: f32,
}

fn oren_nayar(colour: vec3<f32>, roughness: f32, view: vec3<f32>) -> OrenNayar {
    var all: OrenNayar;
    all.colour = colour;
    all.roughness = roughness;
    all.scale = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
    if roughness > 0.0 {
        // 1 less the mean, without cancellation: scale (1/2 - 2/(3 pi) - 2/3 + 28/(15 pi)) roughness.
        let mean = all.scale * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness);
        let gone = max(all.scale * 0.2153052 * roughness, 1e-9);
        all.several = colour * colour * mean / (1.0 - colour * gone) / (PI * gone);
        all.lost = single_lost(all, view.z);
    }
    return all;
}

fn polynomial(cosine: f32) -> f32 {
    let s = 1.0 - cosine;
    return s * (0.0571085289 + s * (0.491881867 + s * (-0.332181442 + s * 0.0714429953)));
}

// 1 less the albedo of single white slopes.
fn single_lost(lobe: OrenNayar, cosine: f32) -> f32 {
    return lobe.scale * lobe.roughness * (0.28779341 - polynomial(cosine));
}

// `f |cos|`, and the density of directions drawn by the cosine.
fn evaluate_diffuse(lobe: OrenNayar, view: vec3<f32>, side: Side) -> vec4<f32> {
    let light = side.light;
    if light.z <= 0.0 || side.height <= 0.0 {
        return vec4<f32>(0.0);
    }
    let pdf = light.z / PI;
    let cosine = pdf * softened(side);
    if lobe.roughness == 0.0 {
        return vec4<f32>(cosine * lobe.colour, pdf);
    }
    let s = dot(view, light) - view.z * light.z;
    let slope = select(s, s / max(view.z, light.z), s > 0.0);
    let single = lobe.scale * (1.0 + lobe.roughness * slope);
    let several = PI * lobe.lost * single_lost(lobe, light.z);
    return vec4<f32>(cosine * (single * lobe.colour + several * lobe.several), pdf);
}

// `f` of white fibres.
fn fibres(view: vec3<f32>, light: vec3<f32>, roughness: f32) -> f32 {
    let half = view + light;
    let size = length(half);
    if size < 1e-30 {
        return 0.0;
    }
    let exponent = 1.0 / max(roughness * roughness, 0.01);
    let sine = min(length(half.xy) / size, 1.0);
    let power = select(0.0, exp2(exponent * log2(max(sine, 1e-30))), sine > 0.0);
    let v = max(view.z, 0.05);
    let l = max(light.z, 0.05);
    return (2.0 + exponent) * power / (2.0 * PI) / (4.0 * (v + l - v * l));
}

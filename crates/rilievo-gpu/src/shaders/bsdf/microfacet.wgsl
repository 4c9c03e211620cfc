// The twin of `bsdf/microfacet.rs` and `bsdf/fresnel.rs`: GGX facets with Smith's masking, and what they reflect.

// GGX widths below this are taken as smooth.
const SMOOTH: f32 = 1e-4;

// The fifth power of `1 - cosine`.
fn grazing(cosine: f32) -> f32 {
    let s = clamp(1.0 - cosine, 0.0, 1.0);
    let s2 = s * s;
    return s2 * s2 * s;
}

// Reflectance of a clear body whose index is `eta` times that of the side of the light, and the cosine inside.
fn clear_fresnel(cosine: f32, eta: f32) -> vec2<f32> {
    let sin2 = max((1.0 - cosine) * (1.0 + cosine), 0.0) / (eta * eta);
    if sin2 >= 1.0 {
        return vec2<f32>(1.0, 0.0);
    }
    let inside = sqrt(max(1.0 - sin2, 0.0));
    let parallel = (eta * cosine - inside) / (eta * cosine + inside);
    let upright = (cosine - eta * inside) / (cosine + eta * inside);
    return vec2<f32>(0.5 * (parallel * parallel + upright * upright), inside);
}

// Reflectance of an interface of complex index `eta - i k`.
fn absorbing_fresnel(cosine: f32, eta: vec3<f32>, k: vec3<f32>) -> vec3<f32> {
    let c2 = cosine * cosine;
    let s2 = 1.0 - c2;
    let apart = eta * eta - k * k - s2;
    let size = sqrt(apart * apart + 4.0 * eta * eta * k * k);
    let a = sqrt(max(0.5 * (size + apart), vec3<f32>(0.0)));
    let upright = (size + c2 - 2.0 * a * cosine) / (size + c2 + 2.0 * a * cosine);
    let t = 2.0 * a * cosine * s2;
    let u = size * c2 + s2 * s2;
    let parallel = upright * (u - t) / (u + t);
    return 0.5 * (upright + parallel);
}

fn spread_of(w: vec3<f32>, alpha: f32) -> f32 {
    return sqrt(w.z * w.z + alpha * alpha * dot(w.xy, w.xy));
}

fn distribution(normal: vec3<f32>, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let slope = dot(normal.xy, normal.xy) / a2 + normal.z * normal.z;
    return 1.0 / (PI * a2 * slope * slope);
}

fn masked_share(view: vec3<f32>, light: vec3<f32>, alpha: f32) -> f32 {
    let l = abs(light.z);
    let s = spread_of(view, alpha);
    return l * (view.z + s) / (view.z * spread_of(light, alpha) + l * s);
}

// A direction with the facet that sends light from there to the viewer.
struct FacetMet {
    found: bool,
    cosine: f32,
    value: f32,
    pdf: f32,
}

const NOT_MET: FacetMet = FacetMet(false, 0.0, 0.0, 0.0);

// Light from above that facets reflect.
fn facet_reflection(view: vec3<f32>, light: vec3<f32>, alpha: f32) -> FacetMet {
    let half = view + light;
    let size = length(half);
    if light.z <= 0.0 || size < 1e-30 {
        return NOT_MET;
    }
    let normal = half / size;
    let pdf = 0.5 * distribution(normal, alpha) / (view.z + spread_of(view, alpha));
    return FacetMet(true, dot(view, normal), pdf * masked_share(view, light, alpha), pdf);
}

// Light from below that facets refract; `eta` is the index there over that here.
fn facet_refraction(view: vec3<f32>, light: vec3<f32>, alpha: f32, eta: f32) -> FacetMet {
    let half = view + eta * light;
    let size = length(half);
    if light.z >= 0.0 || size < 1e-30 {
        return NOT_MET;
    }
    let normal = select(half, -half, half.z < 0.0) / size;
    let v = dot(view, normal);
    let l = dot(light, normal);
    if v <= 0.0 || l >= 0.0 {
        return NOT_MET;
    }
    let denominator = l + v / eta;
    let facets = 2.0 * v * distribution(normal, alpha) / (view.z + spread_of(view, alpha));
    let pdf = facets * -l / (denominator * denominator);
    return FacetMet(true, v, pdf * masked_share(view, light, alpha), pdf);
}

// Density of directions reflected by visible normals, per steradian, over the whole sphere.
fn reflected_pdf(view: vec3<f32>, light: vec3<f32>, alpha: f32) -> f32 {
    let half = view + light;
    let size = length(half);
    if size < 1e-30 || half.z <= 0.0 {
        return 0.0;
    }
    return 0.5 * distribution(half / size, alpha) / (view.z + spread_of(view, alpha));
}

// The twin of `bsdf/albedo.rs`: numbers over the view's cosine and the roughness, linear in between.
fn table_at(table: u32, cosine: f32, alpha: f32) -> vec2<f32> {
    let x = clamp(sqrt(max(cosine, 0.0)), 0.0, 1.0) * 31.0;
    let y = clamp(sqrt(alpha), 0.0, 1.0) * 23.0;
    let i = min(u32(x), 30u);
    let j = min(u32(y), 22u);
    let at = table + 2u * (j * 32u + i);
    let part = vec2<f32>(x - f32(i), y - f32(j));
    var mixed = vec2<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        let far = vec2<bool>((k & 1u) == 1u, k > 1u);
        let weights = select(1.0 - part, part, far);
        let pair = at + 2u * (k & 1u) + 64u * (k >> 1u);
        mixed += weights.x * weights.y * vec2<f32>(number(pair), number(pair + 1u));
    }
    return mixed;
}

fn gloss_albedo(cosine: f32, alpha: f32) -> vec2<f32> {
    return table_at(scene[GLOSS_TABLE], cosine, alpha);
}

// The factor on a lobe of reflectance `facing` that puts back what several facets reflect.
fn several_facets(facing: vec3<f32>, cosine: f32, alpha: f32) -> vec3<f32> {
    let both = gloss_albedo(cosine, alpha);
    let single = min(both.x + both.y, 1.0);
    return 1.0 + facing * ((1.0 - single) / single);
}

// The GGX width of a roughness.
fn width_of(roughness: f32) -> f32 {
    let r = clamp(roughness, 0.0, 1.0);
    return r * r;
}

// `view` reflected by a facet that it sees.
fn facet_reflected(view: vec3<f32>, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    if alpha < SMOOTH {
        return vec3<f32>(-view.x, -view.y, view.z);
    }
    let facet = square_to_visible_normal(u, view, alpha);
    return 2.0 * dot(view, facet) * facet - view;
}

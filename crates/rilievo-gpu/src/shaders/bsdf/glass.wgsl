// The twin of `bsdf/glass.rs`: clear bodies and clear sheets.

struct GlassLobes {
    colour: vec3<f32>,
    eta: f32,
    alpha: f32,
    several: f32,
    sheet: bool,
}

fn glass_of(material: u32, thin: bool, colour: vec3<f32>, width: f32, front: bool, cosine: f32) -> GlassLobes {
    var lobes: GlassLobes;
    let ior = number(material + MODEL);
    lobes.colour = colour;
    lobes.alpha = width;
    lobes.several = 1.0;
    lobes.sheet = thin;
    if thin {
        lobes.eta = max(ior, 1.0 / ior);
        if width >= SMOOTH {
            let both = gloss_albedo(cosine, width);
            lobes.several = 1.0 / (both.x + both.y);
        }
        return lobes;
    }
    lobes.eta = select(1.0 / ior, ior, front);
    // Without an index facets turn nothing.
    if abs(lobes.eta - 1.0) < 1e-6 {
        lobes.alpha = 0.0;
    }
    if lobes.alpha >= SMOOTH {
        let table = scene[material + MODEL + 2u] + select(0u, 1536u, front);
        lobes.several = 1.0 / table_at(table, cosine, lobes.alpha).x;
    }
    return lobes;
}

// The share that a facet reflects, and the cosine inside.
fn glass_share(lobes: GlassLobes, cosine: f32) -> vec2<f32> {
    let once = clear_fresnel(cosine, lobes.eta);
    return vec2<f32>(select(once.x, 2.0 * once.x / (1.0 + once.x), lobes.sheet), once.y);
}

fn evaluate_glass(lobes: GlassLobes, view: vec3<f32>, side: Side) -> vec4<f32> {
    var all = vec4<f32>(0.0);
    if lobes.alpha < SMOOTH {
        return all;
    }
    for (var k = 0u; k < 2u; k++) {
        let light = select(side.light, side.image, k == 1u);
        if side.height > 0.0 {
            let met = facet_reflection(view, light, lobes.alpha);
            if met.found {
                let share = glass_share(lobes, met.cosine).x;
                all += vec4<f32>(vec3<f32>(lobes.several * share * met.value), share * met.pdf);
            }
            continue;
        }
        var met: FacetMet;
        var scale = 1.0;
        if lobes.sheet {
            met = facet_reflection(view, vec3<f32>(light.xy, -light.z), lobes.alpha);
        } else {
            met = facet_refraction(view, light, lobes.alpha, lobes.eta);
            scale = 1.0 / (lobes.eta * lobes.eta);
        }
        if met.found {
            let through = 1.0 - glass_share(lobes, met.cosine).x;
            all += vec4<f32>(lobes.several * through * met.value * scale * lobes.colour, through * met.pdf);
        }
    }
    return all;
}

fn sample_glass(lobes: GlassLobes, view: vec3<f32>, lobe: f32, u: vec2<f32>) -> DrawnLobe {
    var drawn: DrawnLobe;
    drawn.delta = lobes.alpha < SMOOTH;
    drawn.folds = true;
    drawn.roughness = sqrt(lobes.alpha);
    var facet = vec3<f32>(0.0, 0.0, 1.0);
    if !drawn.delta {
        facet = square_to_visible_normal(u, view, lobes.alpha);
    }
    let cosine = dot(view, facet);
    let share = glass_share(lobes, cosine);
    let up = 2.0 * cosine * facet - view;
    if lobe < share.x {
        drawn.light = up;
        drawn.weight = vec3<f32>(1.0);
        drawn.pdf = share.x;
        drawn.found = up.z > 0.0;
        return drawn;
    }
    drawn.transmitted = true;
    var scale = 1.0;
    if lobes.sheet {
        drawn.light = vec3<f32>(up.xy, -up.z);
    } else {
        drawn.light = (cosine / lobes.eta - share.y) * facet - view / lobes.eta;
        scale = 1.0 / (lobes.eta * lobes.eta);
    }
    drawn.light = normalize(drawn.light);
    drawn.weight = scale * lobes.colour;
    drawn.pdf = 1.0 - share.x;
    drawn.found = drawn.light.z < 0.0;
    return drawn;
}

fn albedo_of_glass(lobes: GlassLobes, view: vec3<f32>) -> vec3<f32> {
    let share = glass_share(lobes, view.z).x;
    return share + (1.0 - share) * lobes.colour;
}

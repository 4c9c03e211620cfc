// The twin of `bsdf/principled.rs`.

// Smallest width of gloss and coat, and the reflectance of the coat straight on.
const NARROWEST: f32 = 1e-3;
const COAT: f32 = 0.04;

fn make_principled(part: ptr<function, Part>, material: u32, front: bool) {
    let view = (*part).frame.view;
    let cosine = view.z;
    let one = vec3<f32>(1.0);
    let base = min(inputs[OWN], one);
    let solid = share_of(7u);
    var left = solid;

    var sheen = min(inputs[OWN + 10u], one);
    let sheen_roughness = share_of(11u);
    var sheen_all = vec3<f32>(0.0);
    if !is_black(sheen) {
        let all = table_at(scene[SHEEN_TABLE], cosine, sheen_roughness * sheen_roughness).x;
        sheen *= left / max(all, 1.0);
        sheen_all = sheen * all;
        left -= largest_of(sheen_all);
    }
    var coat = vec2<f32>(share_of(8u), 0.0);
    var coat_all = 0.0;
    if coat.x > 0.0 {
        let width = width_of(inputs[OWN + 9u].x);
        coat = vec2<f32>(left * coat.x, max(width, NARROWEST));
        let both = gloss_albedo(cosine, coat.y);
        coat_all = coat.x * (COAT * both.x + both.y);
        left -= coat_all;
    }

    let metal = share_of(1u);
    let clear = (1.0 - metal) * share_of(6u);
    let opaque = 1.0 - metal - clear;
    let rough = width_of(inputs[OWN + 2u].x);
    let alpha = max(rough, NARROWEST);
    let both = gloss_albedo(cosine, alpha);
    var facing = vec3<f32>(0.0);
    var edge = vec3<f32>(0.0);
    if metal > 0.0 {
        let several = left * metal * several_facets(base, cosine, alpha);
        facing += several * base;
        edge += several;
    }
    var under = vec3<f32>(0.0);
    // What floats leave of three shares that add up to 1.
    if opaque > 1e-7 {
        let ior = number(material + MODEL);
        let step_of = (ior - 1.0) / (ior + 1.0);
        let weight = share_of(4u);
        let f0 = weight * step_of * step_of * min(inputs[OWN + 5u], one);
        let several = several_facets(f0, cosine, alpha);
        let gloss = several * (f0 * both.x + weight * both.y);
        facing += left * opaque * several * f0;
        edge += left * opaque * weight * several;
        under = left * opaque * max(1.0 - largest_of(gloss), 0.0) * base;
    }
    var glass_all = vec3<f32>(0.0);
    (*part).glass_weight = 0.0;
    if GLASSES {
        if clear > 0.0 {
            let thin = scene[material + MODEL + 1u] != 0u;
            (*part).glass = glass_of(material, thin, base, rough, front, cosine);
            (*part).glass_weight = left * clear;
            glass_all = left * clear * albedo_of_glass((*part).glass, view);
        }
    }
    let dullness = share_of(3u);
    (*part).diffuse = oren_nayar(under, dullness, view);
    (*part).open = 1.0 - solid;
    let gloss_all = facing * both.x + edge * both.y;
    var share = array<f32, 5>(
        (*part).open,
        coat_all,
        largest_of(gloss_all),
        (*part).glass_weight,
        largest_of(under) + largest_of(sheen_all),
    );
    let total = share[0] + share[1] + share[2] + share[3] + share[4];
    for (var k = 0u; k < 5u; k++) {
        (*part).share[k] = select(share[k], share[k] / total, total > 0.0);
    }
    (*part).coat = coat;
    (*part).facing = facing;
    (*part).edge = edge;
    (*part).alpha = alpha;
    (*part).sheen = sheen;
    (*part).sheen_roughness = sheen_roughness;
}

fn evaluate_principled(part: Part, side: Side) -> vec4<f32> {
    var all = vec4<f32>(0.0);
    let view = part.frame.view;
    if GLASSES {
        if part.glass_weight > 0.0 {
            let more = evaluate_glass(part.glass, view, side);
            all += vec4<f32>(part.glass_weight * more.xyz, part.share[3] * more.w);
        }
    }
    if side.height <= 0.0 {
        return all;
    }
    for (var k = 0u; k < 2u; k++) {
        let light = select(side.light, side.image, k == 1u);
        if part.share[2] > 0.0 {
            let met = facet_reflection(view, light, part.alpha);
            if met.found {
                let reflectance = part.facing + (part.edge - part.facing) * grazing(met.cosine);
                all += vec4<f32>(met.value * reflectance, part.share[2] * met.pdf);
            }
        }
        if part.share[1] > 0.0 {
            let met = facet_reflection(view, light, part.coat.y);
            if met.found {
                let reflectance = COAT + (1.0 - COAT) * grazing(met.cosine);
                all += vec4<f32>(vec3<f32>(part.coat.x * met.value * reflectance), part.share[1] * met.pdf);
            }
        }
    }
    if part.share[4] > 0.0 {
        let more = evaluate_diffuse(part.diffuse, view, side);
        all += vec4<f32>(more.xyz, part.share[4] * more.w);
        if !is_black(part.sheen) && more.w > 0.0 {
            let value = side.light.z * fibres(view, side.light, part.sheen_roughness);
            all += vec4<f32>(value * part.sheen, 0.0);
        }
    }
    return all;
}

fn sample_principled(part: Part, lobe: f32, u: vec2<f32>) -> DrawnLobe {
    var drawn: DrawnLobe;
    var rest = lobe;
    var chosen = 0u;
    while chosen < 4u && rest >= part.share[chosen] {
        rest -= part.share[chosen];
        chosen += 1u;
    }
    let share = part.share[chosen];
    if share <= 0.0 {
        return drawn;
    }
    let view = part.frame.view;
    switch chosen {
        case 0u: {
            drawn.found = true;
            drawn.light = -view;
            drawn.delta = true;
            drawn.weight = vec3<f32>(part.open / share);
            drawn.pdf = share;
            drawn.folds = true;
            drawn.transmitted = true;
        }
        case 1u, 2u: {
            let alpha = select(part.alpha, part.coat.y, chosen == 1u);
            drawn.light = facet_reflected(view, alpha, u);
            drawn.found = drawn.light.z > 0.0;
            drawn.folds = true;
            drawn.roughness = sqrt(alpha);
        }
        case 3u: {
            if GLASSES {
                drawn = sample_glass(part.glass, view, min(rest / share, LARGEST_BELOW_1), u);
                drawn.weight *= part.glass_weight / share;
                drawn.pdf *= share;
            }
        }
        default: {
            drawn = dull_lobe(u);
        }
    }
    return drawn;
}

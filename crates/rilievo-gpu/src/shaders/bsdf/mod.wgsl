// The twin of `bsdf/mod.rs`: a material at one hit, ready to be asked. What is asked of several parts or for several
// directions is asked in loops: drivers put every function where it is called, and take as long to compile it.

struct Bsdf {
    // What the material sends out.
    emitted: vec3<f32>,
    // The second counts where its share is above 0.
    parts: array<Part, 2>,
    share: f32,
}

// A direction that was drawn.
struct ScatteredLight {
    found: bool,
    direction: vec3<f32>,
    weight: vec3<f32>,
    pdf: f32,
    delta: bool,
    roughness: f32,
}

// A material seen from a side; where it only sends out light, nothing else is worked out.
fn bsdf_of(material: u32, point: Point, view: vec3<f32>, at: Footprint, shines_only: bool) -> Bsdf {
    var bsdf: Bsdf;
    // The material, and the parts of a mix.
    var materials = array<u32, 3>(material, material, material);
    var count = 1u;
    var parts = 0u;
    for (var k = 0u; k < count; k++) {
        let here = materials[k];
        read_inputs(here, select(scene[here + INPUTS], EMITTED + 1u, shines_only), at);
        if k == 0u {
            bsdf.emitted = inputs[EMITTED];
        }
        if shines_only {
            break;
        }
        if MIXES {
            if k == 0u && scene[here] == MIX {
                let share = share_of(0u);
                let first = scene[here + MODEL];
                let second = scene[here + MODEL + 1u];
                materials = array<u32, 3>(here, select(first, second, share == 1.0), second);
                let both = share > 0.0 && share < 1.0;
                bsdf.share = select(0.0, share, both);
                count = select(2u, 3u, both);
                continue;
            }
        }
        bsdf.parts[parts] = part_of(here, point, view);
        parts += 1u;
    }
    return bsdf;
}

// `f |cos|` for light from a direction, and the density with which it is drawn.
fn evaluate_bsdf(bsdf: ptr<function, Bsdf>, light: vec3<f32>) -> vec4<f32> {
    if !MIXES {
        return evaluate_part((*bsdf).parts[0], light);
    }
    let share = (*bsdf).share;
    var all = vec4<f32>(0.0);
    for (var k = 0u; k < select(1u, 2u, share > 0.0); k++) {
        all += select(1.0 - share, share, k == 1u) * evaluate_part((*bsdf).parts[k], light);
    }
    return all;
}

// Draws a direction; unless it is `delta`, weight and density follow from what the material says of it.
fn sample_bsdf(bsdf: ptr<function, Bsdf>, lobe: f32, u: vec2<f32>) -> ScatteredLight {
    var out: ScatteredLight;
    var probability = 1.0;
    var chosen = 0u;
    var rest = lobe;
    if MIXES {
        let share = (*bsdf).share;
        if share > 0.0 && lobe < share {
            chosen = 1u;
            probability = share;
            rest = min(lobe / share, LARGEST_BELOW_1);
        } else if share > 0.0 {
            probability = 1.0 - share;
            rest = clamp((lobe - share) / probability, 0.0, LARGEST_BELOW_1);
        }
    }
    let drawn = sample_part((*bsdf).parts[chosen], rest, u);
    out.found = drawn.found;
    out.direction = drawn.light;
    out.delta = drawn.delta;
    out.roughness = drawn.roughness;
    out.weight = drawn.weight;
    out.pdf = probability * drawn.pdf;
    return out;
}

// The weight and density of a direction that was drawn; it is lost where there are none.
fn weighed(drawn: ScatteredLight, value: vec4<f32>) -> ScatteredLight {
    var out = drawn;
    if !drawn.delta {
        out.weight = value.xyz / value.w;
        out.pdf = value.w;
    }
    let brings = largest_of(abs(out.weight)) < ENDLESS && !is_black(out.weight);
    out.found = drawn.found && out.pdf > 0.0 && brings;
    return out;
}

fn bsdf_transmits(bsdf: ptr<function, Bsdf>) -> bool {
    let second = MIXES && (*bsdf).share > 0.0 && part_transmits((*bsdf).parts[1]);
    return part_transmits((*bsdf).parts[0]) || second;
}

fn bsdf_is_delta(bsdf: ptr<function, Bsdf>) -> bool {
    let second = MIXES && (*bsdf).share > 0.0 && !part_is_delta((*bsdf).parts[1]);
    return part_is_delta((*bsdf).parts[0]) && !second;
}

// The twin of `bsdf/part.rs` and `bsdf/lambert_gloss.rs`: a material that is no mix, at one hit.

const PAPER: u32 = 0u;
const DIFFUSE: u32 = 1u;
const CONDUCTOR: u32 = 2u;
const GLASS: u32 = 3u;
const THIN_GLASS: u32 = 4u;
const PRINCIPLED: u32 = 5u;
const MIX: u32 = 6u;

struct Part {
    frame: Frame,
    kind: u32,
    diffuse: OrenNayar,
    glass: GlassLobes,
    // The reflective share of the paper's model; a metal's reflectance straight on, or its index; of gloss the
    // reflectance straight on, with all weights.
    facing: vec3<f32>,
    // The metal's dip or absorption; of gloss the reflectance at grazing angles.
    edge: vec3<f32>,
    // Of a metal: by its index.
    by_index: bool,
    several: vec3<f32>,
    alpha: f32,
    // Of the paper's model: the probability of the reflective lobe.
    gloss_share: f32,
    // Of a principled surface: weight and width of the coat, the sheen and its roughness, the weight of the glass.
    coat: vec2<f32>,
    sheen: vec3<f32>,
    sheen_roughness: f32,
    glass_weight: f32,
    // Probabilities of passing straight through, coat, gloss, glass and what is dull.
    share: array<f32, 5>,
    open: f32,
}

// A direction that was drawn, in local coordinates.
struct DrawnLobe {
    found: bool,
    light: vec3<f32>,
    delta: bool,
    weight: vec3<f32>,
    pdf: f32,
    folds: bool,
    transmitted: bool,
    roughness: f32,
}

// The inputs of the material are those at hand.
fn part_of(material: u32, point: Point, view: vec3<f32>) -> Part {
    var part: Part;
    var shading = point.shading;
    if NORMALS {
        if scene[material + FIRST_INPUT + 4u * DETAIL + 3u] != NOTHING {
            let n = 2.0 * inputs[DETAIL] - 1.0;
            let strength = vec2<f32>(number(material + STRENGTHS), number(material + STRENGTHS + 1u));
            shading = detailed(point, vec3<f32>(strength * n.xy, n.z));
        }
    }
    part.frame = frame_of(point, shading, view);
    part.kind = scene[material];
    let local_view = part.frame.view;
    switch part.kind {
        case DIFFUSE: {
            let colour = min(inputs[OWN], vec3<f32>(1.0));
            let roughness = share_of(1u);
            part.diffuse = oren_nayar(colour, roughness, local_view);
        }
        case CONDUCTOR: {
            if METALS {
                make_metal(&part, material);
            }
        }
        case GLASS, THIN_GLASS: {
            if GLASSES {
                let thin = part.kind == THIN_GLASS;
                let alpha = width_of(inputs[OWN + 1u].x);
                let colour = inputs[OWN];
                part.glass = glass_of(material, thin, colour, alpha, point.front, local_view.z);
                if scene[material + MODEL + 1u] == 0u {
                    part.glass.several = 1.0;
                }
            }
        }
        case PRINCIPLED: {
            if PRINCIPLEDS {
                make_principled(&part, material, point.front);
            }
        }
        default: {
            part.kind = PAPER;
            part.diffuse.colour = inputs[DULL];
            part.facing = reflective_of(material);
            let dull = largest_of(part.diffuse.colour);
            let bright = largest_of(part.facing);
            part.gloss_share = select(0.0, bright / max(dull + bright, 1e-37), bright > 0.0);
            part.alpha = alpha_of(material);
        }
    }
    return part;
}

fn evaluate_part(part: Part, world_light: vec3<f32>) -> vec4<f32> {
    let side = side_of(part.frame, world_light);
    let view = part.frame.view;
    switch part.kind {
        case DIFFUSE: {
            return evaluate_diffuse(part.diffuse, view, side);
        }
        case CONDUCTOR: {
            var all = vec4<f32>(0.0);
            if METALS {
                if part.alpha < SMOOTH || side.height <= 0.0 {
                    return all;
                }
                for (var k = 0u; k < 2u; k++) {
                    let light = select(side.light, side.image, k == 1u);
                    let met = facet_reflection(view, light, part.alpha);
                    if met.found {
                        all += vec4<f32>(met.value * metal_at(part, met.cosine), met.pdf);
                    }
                }
            }
            return all * vec4<f32>(part.several, 1.0);
        }
        case GLASS, THIN_GLASS: {
            if GLASSES {
                return evaluate_glass(part.glass, view, side);
            }
            return vec4<f32>(0.0);
        }
        case PRINCIPLED: {
            if PRINCIPLEDS {
                return evaluate_principled(part, side);
            }
            return vec4<f32>(0.0);
        }
        default: {
            if side.height <= 0.0 {
                return vec4<f32>(0.0);
            }
            let dull = max(side.light.z, 0.0) / PI;
            var all = vec4<f32>(dull * part.diffuse.colour, (1.0 - part.gloss_share) * dull);
            if part.gloss_share > 0.0 && part.alpha > 0.0 {
                let gloss = reflected_pdf(view, side.light, part.alpha)
                    + reflected_pdf(view, side.image, part.alpha);
                all += vec4<f32>(gloss * part.facing, part.gloss_share * gloss);
            }
            return all;
        }
    }
}

fn dull_lobe(u: vec2<f32>) -> DrawnLobe {
    var drawn: DrawnLobe;
    drawn.found = true;
    drawn.light = square_to_hemisphere(u);
    drawn.roughness = 1.0;
    return drawn;
}

// Draws a direction of the part's lobes, in world space, on its side of the surface.
fn sample_part(part: Part, lobe: f32, u: vec2<f32>) -> DrawnLobe {
    var drawn: DrawnLobe;
    let view = part.frame.view;
    switch part.kind {
        case DIFFUSE: {
            drawn = dull_lobe(u);
        }
        case CONDUCTOR: {
            if METALS {
                drawn.light = facet_reflected(view, part.alpha, u);
                drawn.delta = part.alpha < SMOOTH;
                drawn.found = drawn.delta || drawn.light.z > 0.0;
                drawn.weight = metal_at(part, view.z);
                drawn.pdf = 1.0;
                drawn.folds = true;
                drawn.roughness = sqrt(part.alpha);
            }
        }
        case GLASS, THIN_GLASS: {
            if GLASSES {
                drawn = sample_glass(part.glass, view, lobe, u);
            }
        }
        case PRINCIPLED: {
            if PRINCIPLEDS {
                drawn = sample_principled(part, lobe, u);
            }
        }
        default: {
            if lobe >= part.gloss_share {
                drawn = dull_lobe(u);
            } else {
                var normal = vec3<f32>(0.0, 0.0, 1.0);
                drawn.delta = part.alpha == 0.0;
                if !drawn.delta {
                    normal = square_to_visible_normal(u, view, part.alpha);
                }
                drawn.found = true;
                drawn.light = 2.0 * dot(view, normal) * normal - view;
                drawn.weight = part.facing / part.gloss_share;
                drawn.pdf = part.gloss_share;
                drawn.folds = true;
                drawn.roughness = sqrt(part.alpha);
            }
        }
    }
    if !drawn.found {
        return drawn;
    }
    let height = dot(drawn.light, part.frame.geometric);
    let wrong = select((height < 0.0), (height > 0.0), drawn.transmitted);
    let folded = drawn.light - 2.0 * height * part.frame.geometric;
    drawn.light = world_of(part.frame, select(drawn.light, folded, wrong));
    drawn.found = !wrong || drawn.folds;
    return drawn;
}

// Whether light from behind the surface can reach the viewer.
fn part_transmits(part: Part) -> bool {
    if part.kind == PRINCIPLED {
        return part.glass_weight > 0.0 || part.open > 0.0;
    }
    return part.kind == GLASS || part.kind == THIN_GLASS;
}

// Whether every lobe is a single direction.
fn part_is_delta(part: Part) -> bool {
    switch part.kind {
        case PAPER: { return is_black(part.diffuse.colour) && part.alpha == 0.0; }
        case CONDUCTOR: { return part.alpha < SMOOTH; }
        case GLASS, THIN_GLASS: { return part.glass.alpha < SMOOTH; }
        case PRINCIPLED: {
            let glass = part.glass_weight <= 0.0 || part.glass.alpha < SMOOTH;
            return glass && part.share[1] + part.share[2] + part.share[4] == 0.0;
        }
        default: { return false; }
    }
}

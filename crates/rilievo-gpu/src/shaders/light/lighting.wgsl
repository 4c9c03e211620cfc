// The twin of `light/lighting.rs`: all light of a scene, for paths.

// A light that was drawn, and the surface that cannot be in its way.
struct DrawnLight {
    sample: LightSample,
    exempt: u32,
    surface: u32,
    // Of an emitter that a ray is aimed at: itself, and whether only the point that was drawn counts.
    aimed: u32,
    exact: bool,
}

fn infinite_lights() -> u32 {
    var count = scene[SUNS];
    if HAS_SKY {
        count += select(0u, 1u, sky_rows() > 0u);
    }
    return count;
}

fn draw_light(at: Receiver, choice: f32, u: vec2<f32>) -> DrawnLight {
    var drawn: DrawnLight;
    drawn.exempt = NOTHING;
    drawn.surface = NOTHING;
    drawn.aimed = NOTHING;
    let groups = scene[GROUPS];
    if groups == 0u {
        return drawn;
    }
    let among = choice * f32(groups);
    let group = min(u32(among), groups - 1u);
    var probability = 1.0;
    if group < scene[SUNS] {
        drawn.sample = sample_sun(scene[FIRST_SUN] + LIGHT_RECORD * group, u);
    } else if group < infinite_lights() {
        if HAS_SKY {
            drawn.sample = sample_sky(u);
        }
    } else {
        var chosen = Chosen(0u, 1.0, min(among - f32(group), LARGEST_BELOW_1));
        var light = 0u;
        var seen = 0u;
        var receiver = at;
        var part = 0u;
        nodes_now = scene[TREE];
        // A light; of triangles that have a shape, one of them.
        for (var k = 0u; k < 2u; k++) {
            chosen = choose_light(receiver, chosen.rest);
            if chosen.probability <= 0.0 {
                return drawn;
            }
            if k == 1u {
                part = chosen.light;
                break;
            }
            probability = chosen.probability;
            light = scene[FIRST_DRAWN] + LIGHT_RECORD * chosen.light;
            seen = light;
            if !is_emitter(light) {
                break;
            }
            seen = scene[light + LIGHT_SHAPE];
            receiver = receiver_of(light, at);
            if scene[seen + LIGHT_KIND] != TRIANGLE_LIGHT {
                break;
            }
            nodes_now = scene[seen + LIGHT_SHAPE];
        }
        let view = view_of(seen, receiver.position);
        if EMITTERS && seen != light {
            drawn.sample = aim_at(light, receiver, at.position, view, part, u);
            drawn.aimed = scene[light + LIGHT_SURFACE];
            drawn.exact = scene[seen + LIGHT_KIND] != SPHERE_LIGHT;
            return drawn;
        }
        if !view.visible {
            return drawn;
        }
        drawn.sample = sample_light(light, at.position, view, u);
        drawn.exempt = exempt_of(light);
        // A flat quad or a sphere cannot light itself.
        drawn.surface = drawn.exempt;
    }
    probability /= f32(groups);
    drawn.sample.weight /= probability;
    drawn.sample.pdf *= probability;
    return drawn;
}

// Density with which `draw_light` gives a unit direction that meets an emitter's front.
fn pdf_of_hit(at: Receiver, direction: vec3<f32>, point: Point) -> f32 {
    var index = scene[record_of(point.surface) + 5u];
    if index == NOTHING {
        return 0.0;
    }
    let emits = is_emitter(scene[FIRST_DRAWN] + LIGHT_RECORD * index);
    // Of triangles the number, else 0.
    let triangles = scene[record_of(point.surface) + 3u] == TRIANGLES;
    index += select(0u, u32(point.line), triangles && !emits);
    let light = scene[FIRST_DRAWN] + LIGHT_RECORD * index;
    var receiver = at;
    var seen = light;
    if emits {
        receiver = receiver_of(light, at);
        seen = scene[light + LIGHT_SHAPE];
    }
    let view = view_of(seen, receiver.position);
    var pdf: f32;
    if emits {
        pdf = emitter_pdf(light, receiver, direction, view, point);
    } else {
        let distance = length(way_between(at.position, point.position));
        pdf = light_pdf(light, view, direction, distance);
    }
    nodes_now = scene[TREE];
    var ways = scene[WAYS];
    let inner = emits && scene[seen + LIGHT_KIND] == TRIANGLE_LIGHT;
    for (var k = 0u; k < select(1u, 2u, inner); k++) {
        var asker = at;
        if k == 1u {
            nodes_now = scene[seen + LIGHT_SHAPE];
            ways = scene[seen + LIGHT_SHAPE + 1u];
            index = u32(point.line);
            asker = receiver;
        }
        pdf *= light_probability(asker, ways, index);
    }
    return pdf / f32(scene[GROUPS]);
}

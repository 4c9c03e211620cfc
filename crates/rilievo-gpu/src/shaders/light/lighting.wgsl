// The twin of `light/lighting.rs`: all light of a scene, for paths.

// A light that was drawn, and the surface that cannot be in its way.
struct DrawnLight {
    sample: LightSample,
    exempt: u32,
    surface: u32,
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
        let chosen = choose_light(at, min(among - f32(group), LARGEST_BELOW_1));
        if chosen.probability <= 0.0 {
            return drawn;
        }
        probability = chosen.probability;
        let light = scene[FIRST_DRAWN] + LIGHT_RECORD * chosen.light;
        let view = view_of(light, at.position);
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
    let first = scene[record_of(point.surface) + 5u];
    if first == NOTHING {
        return 0.0;
    }
    // Of triangles the number, else 0.
    let triangles = scene[record_of(point.surface) + 3u] == TRIANGLES;
    let index = first + select(0u, u32(point.line), triangles);
    let light = scene[FIRST_DRAWN] + LIGHT_RECORD * index;
    let distance = length(way_between(at.position, point.position));
    let pdf = light_pdf(light, at.position, direction, distance);
    return pdf * light_probability(at, index) / f32(scene[GROUPS]);
}

// The twin of `light/mod.rs`, `light/triangle.rs`, `light/sphere.rs` and `light/punctual.rs`: a point of a light as seen
// from another point. Ways to lights are doubles, so that rays end on them; all else is floats.

const LIGHT_EDGES: u32 = 6u;
const LIGHT_NORMAL: u32 = 18u;
const LIGHT_AREA: u32 = 21u;
const LIGHT_EMITTED: u32 = 22u;
const LIGHT_KIND: u32 = 25u;
const LIGHT_SURFACE: u32 = 26u;
const LIGHT_RECTANGULAR: u32 = 27u;

const QUAD_LIGHT: u32 = 0u;
const TRIANGLE_LIGHT: u32 = 1u;
const SPHERE_LIGHT: u32 = 2u;
const POINT_LIGHT: u32 = 3u;

// A point of a light as seen from another point.
struct LightSample {
    // From that point; a ray along it ends at `end` lengths.
    way: Place3,
    end: Double,
    // Unit.
    direction: vec3<f32>,
    // Radiance over the density.
    weight: vec3<f32>,
    // Per steradian; 0 of a light without extent.
    pdf: f32,
    valid: bool,
}

// How a light is seen from a point.
struct LightView {
    visible: bool,
    // From the point to the light's corner, centre or place.
    way: vec3<f32>,
    // Of a rectangle that goes by solid angle.
    solid: bool,
    x: vec2<f32>,
    y: vec2<f32>,
    z: f32,
    b: vec2<f32>,
    k: vec2<f32>,
    solid_angle: f32,
    // Of a sphere: 1 less the cosine of half the angle of its cone.
    height: f32,
}

fn exempt_of(light: u32) -> u32 {
    // No other part of a quad or a sphere is in the way of what is seen of it.
    let kind = scene[light + LIGHT_KIND];
    return select(NOTHING, scene[light + LIGHT_SURFACE], kind == QUAD_LIGHT || kind == SPHERE_LIGHT);
}

// The share of a way that lies before the plane at its end, whatever doubles round.
fn clear_share(start: Place3, way: vec3<f32>, normal: vec3<f32>) -> Double {
    let across = abs(dot(way, normal));
    let reach = 2.0 * largest_of(abs(rough_place(start))) + largest_of(abs(way));
    let rounding = 32.0 * 7.2e-15 * reach;
    return quick_two_sum(1.0, -min(rounding / max(across, 1e-37) + 3e-14, 0.5));
}

fn view_of(light: u32, position: Place3) -> LightView {
    var view: LightView;
    view.visible = true;
    let kind = scene[light + LIGHT_KIND];
    if kind > POINT_LIGHT {
        return view;
    }
    view.way = way_between(position, place_in_scene(light));
    if kind == QUAD_LIGHT {
        view_quad(&view, light);
    } else if kind == SPHERE_LIGHT {
        let sine = number(light + LIGHT_EDGES) / length(view.way);
        view.visible = sine < 1.0;
        view.height = sine * sine / (1.0 + sqrt(max((1.0 - sine) * (1.0 + sine), 0.0)));
    }
    return view;
}

fn sample_light(light: u32, position: Place3, view: LightView, u: vec2<f32>) -> LightSample {
    switch scene[light + LIGHT_KIND] {
        case QUAD_LIGHT: { return sample_quad(light, position, view, u); }
        case TRIANGLE_LIGHT: {
            let side = sqrt(u.x);
            let place = vec2<f32>(side * (1.0 - u.y), side * u.y);
            return sample_flat(light, position, place, 0.0);
        }
        case SPHERE_LIGHT: { return sample_sphere(light, position, view, u); }
        case POINT_LIGHT: { return sample_point(light, position, view.way); }
        default: { return sample_sun(light, u); }
    }
}

// A point of a parallelogram or a triangle by its place along the edges; by area where there is no solid angle.
fn sample_flat(light: u32, position: Place3, place: vec2<f32>, solid_angle: f32) -> LightSample {
    var sample: LightSample;
    for (var k = 0u; k < 3u; k++) {
        let along = sum(
            scaled(double_in_scene(light + 6u + 2u * k), place.x),
            scaled(double_in_scene(light + 12u + 2u * k), place.y),
        );
        let end = sum(double_in_scene(light + 2u * k), along);
        sample.way[k] = difference(end, position[k]);
    }
    let way = rough_place(sample.way);
    let normal = triple(light + LIGHT_NORMAL);
    let inverse = 1.0 / length(way);
    let cosine = -dot(way, normal) * inverse;
    // Rounding may turn a grazing light away.
    sample.valid = cosine > 0.0 && inverse < ENDLESS;
    if !sample.valid {
        return sample;
    }
    let by_area = number(light + LIGHT_AREA) * cosine * inverse * inverse;
    let angle = select(by_area, solid_angle, solid_angle > 0.0);
    sample.direction = way * inverse;
    sample.weight = triple(light + LIGHT_EMITTED) * angle;
    sample.pdf = 1.0 / angle;
    sample.end = clear_share(position, way, normal);
    return sample;
}

fn sample_sphere(light: u32, position: Place3, view: LightView, u: vec2<f32>) -> LightSample {
    var sample: LightSample;
    sample.valid = true;
    let radius = number(light + LIGHT_EDGES);
    let forward = normalize(view.way);
    sample.direction = normalize(around(forward, square_to_cone(u, view.height)));
    // The nearer meeting with the sphere; at the rim the square root is held at 0.
    let along = dot(view.way, sample.direction);
    let beside = view.way - along * sample.direction;
    let half_chord = sqrt(max(radius * radius - dot(beside, beside), 0.0));
    let way = (along - half_chord) * sample.direction;
    sample.way = Place3(double(way.x), double(way.y), double(way.z));
    sample.pdf = cone_pdf(view.height);
    sample.weight = triple(light + LIGHT_EMITTED) / sample.pdf;
    // The light itself is exempt, and what touches it lies no deeper than floats tell.
    sample.end = clear_share(position, way, (way - view.way) / radius);
    return sample;
}

fn sample_point(light: u32, position: Place3, way: vec3<f32>) -> LightSample {
    var sample: LightSample;
    let squared = dot(way, way);
    sample.direction = way / sqrt(squared);
    var share = 1.0;
    let axis = triple(light + 6u);
    if any(axis != vec3<f32>(0.0)) {
        let outer = number(light + 10u);
        let part = (-dot(sample.direction, axis) - outer) / (number(light + 9u) - outer);
        share = clamp(part, 0.0, 1.0) * clamp(part, 0.0, 1.0);
    }
    sample.valid = share > 0.0 && squared > 0.0;
    for (var k = 0u; k < 3u; k++) {
        sample.way[k] = difference(double_in_scene(light + 2u * k), position[k]);
    }
    sample.end = double(1.0);
    sample.weight = triple(light + LIGHT_EMITTED) * (share / squared);
    return sample;
}

fn sample_sun(light: u32, u: vec2<f32>) -> LightSample {
    var sample: LightSample;
    sample.valid = true;
    let towards = triple(light);
    let height = number(light + 3u);
    sample.direction = towards;
    sample.weight = triple(light + LIGHT_EMITTED);
    if height > 0.0 {
        sample.direction = normalize(around(towards, square_to_cone(u, height)));
        sample.pdf = cone_pdf(height);
        sample.weight = triple(light + 4u) / sample.pdf;
    }
    let way = sample.direction;
    sample.way = Place3(double(way.x), double(way.y), double(way.z));
    sample.end = double(ENDLESS);
    return sample;
}

// Whether a sun is seen in a unit direction.
fn sees_sun(light: u32, direction: vec3<f32>) -> bool {
    let apart = direction - triple(light);
    return 0.5 * dot(apart, apart) < number(light + 3u);
}

// Density with which a point of the light is drawn as it is seen, in a unit direction that meets its front at a
// distance, per steradian.
fn light_pdf(light: u32, view: LightView, direction: vec3<f32>, distance: f32) -> f32 {
    let kind = scene[light + LIGHT_KIND];
    if !view.visible || kind >= POINT_LIGHT {
        return 0.0;
    }
    if kind == SPHERE_LIGHT {
        return cone_pdf(view.height);
    }
    if view.solid {
        return 1.0 / view.solid_angle;
    }
    let cosine = -dot(direction, triple(light + LIGHT_NORMAL));
    return select(0.0, distance * distance / (number(light + LIGHT_AREA) * cosine), cosine > 0.0);
}

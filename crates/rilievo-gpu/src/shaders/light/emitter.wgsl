// The twin of `light/emitter.rs`, `light/shape.rs` and `light/emission.rs`: emitters that have no closed form. A ray is
// aimed at one, and what it meets is the sample. `EMITTERS` is written by `shaders.rs`.

const EMITTER: u32 = 5u;
// Of an emitter the place of its shape, whose words are those of a light, and then: of a parallelogram the place of its
// table, and half the range of its offsets; of triangles the places of the tree over them and of the ways in it.
const LIGHT_SHAPE: u32 = 28u;
const SHAPE_TABLE: u32 = 28u;
const SHAPE_RANGE: u32 = 29u;

// Two points of an emitter closer than this share of the way to them are one.
const SAME: f32 = 1e-5;

fn is_emitter(light: u32) -> bool {
    return EMITTERS && scene[light + LIGHT_KIND] == EMITTER;
}

// The transforms of an emitter, or NOTHING.
fn transform_of(light: u32) -> u32 {
    return scene[record_of(scene[light + LIGHT_SURFACE]) + 6u];
}

// A receiver in the frame in which an emitter was made.
fn receiver_of(light: u32, at: Receiver) -> Receiver {
    let transform = transform_of(light);
    if !INSTANCES || transform == NOTHING {
        return at;
    }
    let normal = unit_or(turned_by_transpose(transform + 24u, at.normal), vec3<f32>(0.0, 0.0, 1.0));
    return Receiver(transformed_place(transform, at.position, true), normal, at.both_sides);
}

// The view of a parallelogram's base, where it is good for drawing places of it.
fn base_view(shape: u32, view: LightView) -> bool {
    let height = -dot(view.way, triple(shape + LIGHT_NORMAL));
    return view.visible && view.solid && height > 2.0 * number(shape + SHAPE_RANGE);
}

// A place of the base by the light that is sent out from there.
fn emitting_place(table: u32, u: vec2<f32>) -> vec2<f32> {
    let columns = scene[table];
    let size = vec2<f32>(f32(columns), f32(scene[table + 1u]));
    // The row, then the cell in it.
    var place: vec2<f32>;
    var sums = scene[table + 2u];
    for (var k = 0u; k < 2u; k++) {
        let found = inverted(sums, scene[table + 1u - k], select(u.y, u.x, k == 1u));
        place[1u - k] = f32(found.part) + found.within;
        sums = scene[table + 3u] + found.part * (columns + 1u);
    }
    return place / size;
}

// Its density over the unit square.
fn emitting_pdf(table: u32, uv: vec2<f32>) -> f32 {
    let size = vec2<u32>(scene[table], scene[table + 1u]);
    let cell = min(vec2<u32>(max(uv, vec2<f32>(0.0)) * vec2<f32>(size)), size - 1u);
    var share = 1.0;
    var sums = scene[table + 2u] + cell.y;
    for (var k = 0u; k < 2u; k++) {
        share *= number(sums + 1u) - number(sums);
        sums = scene[table + 3u] + cell.y * (size.x + 1u) + cell.x;
    }
    return share * f32(size.x) * f32(size.y);
}

// A place of the base of a parallelogram.
fn base_place(shape: u32, uv: vec2<f32>) -> Place3 {
    var place: Place3;
    for (var k = 0u; k < 3u; k++) {
        let along = sum(
            scaled(double_in_scene(shape + 6u + 2u * k), uv.x),
            scaled(double_in_scene(shape + 12u + 2u * k), uv.y),
        );
        place[k] = sum(double_in_scene(shape + 2u * k), along);
    }
    return place;
}

// A point of triangle `index` of a surface of triangles, displaced or not.
fn place_on_triangle(record: u32, index: u32, v: f32, w: f32) -> Place3 {
    let form = scene[record + 1u];
    if RELIEF_MESHES {
        if scene[record + 3u] == RELIEF_MESH {
            return place_on_shell(form, scene[record + 4u], index, vec2<f32>(v, w));
        }
    }
    let triangle = form + 1u + TRIANGLE_FORM * index;
    var place = place_in_scene(triangle);
    let along = v * triple(triangle + 6u) + w * triple(triangle + 9u);
    for (var k = 0u; k < 3u; k++) {
        place[k] = sum(place[k], double(along[k]));
    }
    return place;
}

// A ray towards an emitter, seen from a receiver in the emitter's frame; `part` is the triangle that was chosen. The
// weight and the density are those of what the ray will meet.
fn aim_at(light: u32, at: Receiver, position: Place3, view: LightView, part: u32, u: vec2<f32>) -> LightSample {
    var sample: LightSample;
    let record = record_of(scene[light + LIGHT_SURFACE]);
    let shape = scene[light + LIGHT_SHAPE];
    var end: Place3;
    switch scene[shape + LIGHT_KIND] {
        case QUAD_LIGHT: {
            var uv = u;
            if scene[shape + SHAPE_TABLE] != NOTHING {
                uv = emitting_place(scene[shape + SHAPE_TABLE], u);
            } else if base_view(shape, view) {
                let sides = vec2<f32>(length(edge_of(shape, 0u)), length(edge_of(shape, 1u)));
                uv = place_in_rectangle(view, u) / sides;
            }
            if FACES && scene[record + 3u] == FACE {
                end = place_on_face(scene[record + 1u], scene[record + 4u], uv);
            } else {
                end = base_place(shape, uv);
            }
        }
        case SPHERE_LIGHT: {
            let cone = square_to_cone(u, select(2.0, view.height, view.visible));
            let direction = select(cone, around(normalize(view.way), cone), view.visible);
            let beyond = length(view.way) + 1.001 * number(shape + LIGHT_EDGES);
            for (var k = 0u; k < 3u; k++) {
                end[k] = sum(at.position[k], double(direction[k] * beyond));
            }
        }
        default: {
            let side = sqrt(u.x);
            end = place_on_triangle(record, part, side * (1.0 - u.y), side * u.y);
        }
    }
    if INSTANCES {
        let transform = scene[record + 6u];
        if transform != NOTHING {
            end = transformed_place(transform + 24u, end, true);
        }
    }
    for (var k = 0u; k < 3u; k++) {
        sample.way[k] = difference(end[k], position[k]);
    }
    sample.direction = unit_or(rough_place(sample.way), vec3<f32>(0.0));
    sample.end = double(1.0 + SAME);
    sample.valid = !is_black(sample.direction);
    return sample;
}

// Density with which rays are aimed in a unit direction at what one met, per steradian, without the choice among
// triangles.
fn emitter_pdf(light: u32, at: Receiver, direction: vec3<f32>, view: LightView, point: Point) -> f32 {
    let record = record_of(scene[light + LIGHT_SURFACE]);
    let shape = scene[light + LIGHT_SHAPE];
    let transform = scene[record + 6u];
    let moved = INSTANCES && transform != NOTHING;
    var met = point.position;
    var normal = point.geometric;
    var stretch = 1.0;
    if moved {
        met = transformed_place(transform, point.position, true);
        normal = unit_or(turned_by_transpose(transform + 24u, normal), vec3<f32>(0.0, 0.0, 1.0));
        var rows: array<vec3<f32>, 3>;
        for (var k = 0u; k < 3u; k++) {
            let row = transform + 6u * k;
            rows[k] = vec3<f32>(number(row), number(row + 2u), number(row + 4u));
        }
        let local = length(turned(transform, direction));
        stretch = abs(dot(rows[0], cross(rows[1], rows[2]))) / (local * local * local);
    }
    let kind = scene[shape + LIGHT_KIND];
    if kind == SPHERE_LIGHT {
        return stretch * cone_pdf(select(2.0, view.height, view.visible));
    }
    var over_area = 0.0;
    if kind == QUAD_LIGHT && point.wall == 0u {
        let base = triple(shape + LIGHT_NORMAL);
        over_area = 1.0 / number(shape + LIGHT_AREA);
        if scene[shape + SHAPE_TABLE] != NOTHING {
            over_area *= emitting_pdf(scene[shape + SHAPE_TABLE], point.uv);
        } else if base_view(shape, view) {
            let way = way_between(at.position, base_place(shape, point.uv));
            let squared = dot(way, way);
            over_area = abs(dot(way, base)) / (squared * sqrt(squared) * view.solid_angle);
        }
        if scene[record + 3u] == FACE {
            over_area *= abs(dot(normal, base));
        }
    } else if kind == TRIANGLE_LIGHT && point.wall == 0u && point.spread > 0.0 {
        over_area = 2.0 / point.spread;
    }
    let way = way_between(at.position, met);
    let squared = dot(way, way);
    let pdf = stretch * over_area * squared * sqrt(squared) / abs(dot(way, normal));
    return select(0.0, pdf, pdf < ENDLESS);
}

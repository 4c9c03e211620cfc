// The twin of `relief/face.rs`, `relief/shading.rs` and `map/normal`: points of displaced faces.

const EXACT: u32 = 0u;
const PUBLISHED: u32 = 2u;

// The samples that an unfolded cell joins along an axis.
fn unfolded_joined(axis: u32, cell: i32) -> vec2<i32> {
    let run = run_of(axis, cell);
    let pair = vec2<i32>(joined(axis, stored(run, cell)));
    return select(pair, pair.yx, run.flipped != 0);
}

// The samples around a corner of a cell along an axis: before, own, after, and what the neighbouring cell
// holds in place of own.
fn stencil(axis: u32, cell: i32, far: bool) -> vec4<u32> {
    let here = unfolded_joined(axis, cell);
    if far {
        let next = unfolded_joined(axis, cell + 1);
        return vec4<u32>(vec4<i32>(here.x, here.y, next.y, next.x));
    }
    let last = unfolded_joined(axis, cell - 1);
    return vec4<u32>(vec4<i32>(last.x, here.x, here.y, last.y));
}

// The slope at a corner from the heights of a stencil.
fn slope_of(h: vec4<f32>, far: bool, kind: u32) -> f32 {
    let before = h.y - h.x;
    let after = h.z - h.y;
    if h.w != h.y {
        return select(after, before, far);
    }
    return select(0.5 * (before + after), after, kind == PUBLISHED);
}

// A normal in map axes, of some length.
fn map_normal(kind: u32, steepness: vec2<f32>, cell: vec2<i32>, local: vec2<f32>) -> vec3<f32> {
    if kind == EXACT {
        let h = unfolded_corners(cell);
        let along_x = (h.y - h.x) * (1.0 - local.y) + (h.w - h.z) * local.y;
        let along_y = (h.z - h.x) * (1.0 - local.x) + (h.w - h.y) * local.x;
        return vec3<f32>(-along_x * steepness.x, -along_y * steepness.y, 1.0);
    }
    var normal = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        let far = vec2<bool>((k & 1u) == 1u, (k & 2u) == 2u);
        let x = stencil(0u, cell.x, far.x);
        let y = stencil(1u, cell.y, far.y);
        let own = raw(x.y, y.y);
        let hx = vec4<f32>(raw(x.x, y.y), own, raw(x.z, y.y), raw(x.w, y.y));
        let hy = vec4<f32>(raw(x.y, y.x), own, raw(x.y, y.z), raw(x.y, y.w));
        let s = vec2<f32>(slope_of(hx, far.x, kind), slope_of(hy, far.y, kind)) * steepness;
        let weights = select(vec2<f32>(1.0) - local, local, far);
        normal += weights.x * weights.y / sqrt(dot(s, s) + 1.0) * vec3<f32>(-s, 1.0);
    }
    return normal;
}

fn normal_of_face(form: u32, n: vec3<f32>) -> vec3<f32> {
    let upright = max(n.z, 1e-9);
    let along = n.x * triple(form + 24u) + n.y * triple(form + 27u);
    return normalize(along + upright * triple(form + 30u));
}

// The raw height at a place of a cell.
fn raw_in_cell(cell: vec2<i32>, local: array<Double, 2>) -> Double {
    let h = unfolded_corners(cell);
    let b = two_sum(h.y, -h.x);
    let c = two_sum(h.z, -h.x);
    let d = difference(two_sum(h.w, -h.z), b);
    let low = sum(double(h.x), product(b, local[0]));
    return sum(low, product(sum(c, product(d, local[0])), local[1]));
}

// The point above a place of the base of a face.
fn place_on_face(form: u32, face_of_map: u32, uv: vec2<f32>) -> Place3 {
    show(face_of_map);
    let scale = vec2<f32>(number(form + 38u), number(form + 39u));
    let shift = vec2<f32>(number(form + 40u), number(form + 41u));
    let at = (uv - shift) / scale;
    let cell = vec2<i32>(floor(at));
    let within = at - floor(at);
    return raised_place(form, cell, array<Double, 2>(double(within.x), double(within.y)));
}

// The point of the face at hand at a place of a cell.
fn raised_place(form: u32, cell: vec2<i32>, local: array<Double, 2>) -> Place3 {
    let x = sum(double(f32(cell.x)), local[0]);
    let y = sum(double(f32(cell.y)), local[1]);
    let raw_height = raw_in_cell(cell, local);
    var place: Place3;
    for (var k = 0u; k < 3u; k++) {
        let flat = sum(
            product(double_in_scene(form + 6u + 2u * k), x),
            product(double_in_scene(form + 12u + 2u * k), y),
        );
        let raised = sum(flat, product(double_in_scene(form + 18u + 2u * k), raw_height));
        place[k] = sum(double_in_scene(form + 2u * k), raised);
    }
    return place;
}

// The point of the face at hand.
fn point_of_face(hit: Hit, source: Ray, form: u32) -> Point {
    var point: Point;
    let front = (hit.part & FRONT) != 0u;
    point.wall = hit.part >> WALL_SHIFT;
    point.along_u = triple(form + 44u);
    point.along_v = triple(form + 47u);
    if point.wall == 0u {
        let local = clamp(vec2<f32>(hit.local[0].x, hit.local[1].x), vec2<f32>(0.0), vec2<f32>(1.0));
        let steepness = vec2<f32>(number(form + 33u), number(form + 34u));
        point.geometric = normal_of_face(form, map_normal(EXACT, steepness, hit.cell, local));
        point.shading = point.geometric;
        let kind = scene[form + 37u];
        if kind != EXACT {
            let steep = vec2<f32>(number(form + 35u), number(form + 36u));
            let normal = normal_of_face(form, map_normal(kind, steep, hit.cell, local));
            point.shading = select(point.geometric, normal, dot(normal, point.geometric) > 0.0);
        }
        point.position = raised_place(form, hit.cell, hit.local);
        let scale = vec2<f32>(number(form + 38u), number(form + 39u));
        let shift = vec2<f32>(number(form + 40u), number(form + 41u));
        let at = (vec2<f32>(hit.cell) + local) * scale + shift;
        point.uv = clamp(at, vec2<f32>(0.0), vec2<f32>(1.0));
        return point;
    }
    // Walls stand along an edge: their normals are kept.
    let along_u = point.wall == 3u || point.wall == 4u || point.wall == 6u;
    let normal = triple(form + select(50u, 53u, along_u));
    let towards = (dot(normal, rough_direction(source)) < 0.0) == front;
    point.geometric = select(-normal, normal, towards);
    point.shading = point.geometric;
    point.line = hit.cell.x;
    point.position = place_along(source, hit.t);
    let way = rough_place(point.position) - triple(form + 56u);
    let at = vec2<f32>(dot(way, triple(form + 59u)), dot(way, triple(form + 62u)));
    point.uv = clamp(at, vec2<f32>(0.0), vec2<f32>(1.0));
    return point;
}

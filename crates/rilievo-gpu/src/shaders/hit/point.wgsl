// The twin of `hit.rs` and of the `complete` of each surface: what a hit looks like to light. The point itself is in
// doubles, on the surface rather than on the ray; all else only shades.

// A hit as light meets it.
struct Point {
    position: Place3,
    // Unit normal towards the front, whichever side was hit, and the one to shade with.
    geometric: vec3<f32>,
    shading: vec3<f32>,
    // Derivatives of the base surface by u and v.
    along_u: vec3<f32>,
    along_v: vec3<f32>,
    uv: vec2<f32>,
    surface: u32,
    // Kind of wall, and the line of a seam or the triangle, as a ray that leaves wants them.
    wall: u32,
    line: i32,
    front: bool,
    // Distance along the ray, scene units.
    distance: f32,
    // Area for an area of 1 of a triangle's weights, before it is moved.
    spread: f32,
}

fn rough_direction(source: Ray) -> vec3<f32> {
    return vec3<f32>(source.direction[0].x, source.direction[1].x, source.direction[2].x);
}

fn place_along(source: Ray, t: Double) -> Place3 {
    var place: Place3;
    for (var k = 0u; k < 3u; k++) {
        place[k] = sum(source.origin[k], product(t, source.direction[k]));
    }
    return place;
}

// Rows of a matrix of doubles and a translation, times a vector.
fn transformed_place(at: u32, v: Place3, moves: bool) -> Place3 {
    var out: Place3;
    for (var k = 0u; k < 3u; k++) {
        let row = at + 6u * k;
        out[k] = sum(
            sum(product(double_in_scene(row), v[0]), product(double_in_scene(row + 2u), v[1])),
            product(double_in_scene(row + 4u), v[2]),
        );
        if moves {
            out[k] = sum(out[k], double_in_scene(at + 18u + 2u * k));
        }
    }
    return out;
}

// Rows of a matrix of doubles, times a vector in floats.
fn turned(at: u32, v: vec3<f32>) -> vec3<f32> {
    var out: vec3<f32>;
    for (var k = 0u; k < 3u; k++) {
        let row = at + 6u * k;
        out[k] = dot(vec3<f32>(number(row), number(row + 2u), number(row + 4u)), v);
    }
    return out;
}

// Columns of it: the product with its transpose.
fn turned_by_transpose(at: u32, v: vec3<f32>) -> vec3<f32> {
    var out = vec3<f32>(0.0);
    for (var k = 0u; k < 3u; k++) {
        let row = at + 6u * k;
        out += v[k] * vec3<f32>(number(row), number(row + 2u), number(row + 4u));
    }
    return out;
}

// The time of all rays of a slot.
var<private> time_now: Double;

// The motion at a place.
fn motion_in_scene(place: u32) -> Motion {
    return Motion(
        place_in_scene(place),
        place_in_scene(place + 6u),
        place_in_scene(place + 12u),
        double_in_scene(place + 18u),
    );
}

// A vector of a prototype's frame at time 0 as it is now, in floats.
fn turned_now(turn: Turn, v: vec3<f32>) -> vec3<f32> {
    let a = rough_place(turn.axis);
    return v * turn.cosine.x + cross(a, v) * turn.sine.x + a * (dot(a, v) * (1.0 - turn.cosine.x));
}

// What a hit looks like.
fn point_of(hit: Hit, source: Ray) -> Point {
    let record = record_of(hit.surface);
    let form = scene[record + 1u];
    let transform = scene[record + 6u];
    let moved = INSTANCES && transform != NOTHING;
    var local = source;
    var turn: Turn;
    let moves = MOVING && moved && scene[record + 7u] != 0u;
    if moves {
        turn = turn_at(motion_in_scene(transform + 48u), source.time);
        local = ray_at_begin(turn, source);
    }
    if moved {
        local.origin = transformed_place(transform, local.origin, true);
        local.direction = transformed_place(transform, local.direction, false);
    }
    var point: Point;
    switch scene[record + 3u] {
        // `shaders.rs` writes which surfaces there are; drivers drop the others.
        case FACE: {
            if FACES {
                show(scene[record + 4u]);
                point = point_of_face(hit, local, form);
            }
        }
        case SPHERE: {
            point = point_of_sphere(hit, local, form);
        }
        case RELIEF_SPHERE: {
            if RELIEF_SPHERES {
                point = point_of_relief_sphere(hit, form, scene[record + 4u]);
            }
        }
        case RELIEF_MESH: {
            if RELIEF_MESHES {
                point = point_of_relief_mesh(hit, local, form, scene[record + 4u]);
            }
        }
        default: {
            point = point_of_triangle(hit, local, form);
        }
    }
    if moved {
        let back = transform + 24u;
        point.position = transformed_place(back, point.position, true);
        point.geometric = normalize(turned_by_transpose(transform, point.geometric));
        let shading = normalize(turned_by_transpose(transform, point.shading));
        // A stretch may open the angle between the two beyond a right one.
        let sided = dot(point.geometric, shading) > 0.0;
        point.shading = select(point.geometric, shading, sided);
        point.along_u = turned(back, point.along_u);
        point.along_v = turned(back, point.along_v);
    }
    if moves {
        let place = turned_about(turn, -turn.sine, point.position);
        for (var k = 0u; k < 3u; k++) {
            point.position[k] = sum(place[k], turn.pivot[k]);
        }
        point.geometric = turned_now(turn, point.geometric);
        point.shading = turned_now(turn, point.shading);
        point.along_u = turned_now(turn, point.along_u);
        point.along_v = turned_now(turn, point.along_v);
    }
    point.surface = hit.surface;
    point.front = (hit.part & FRONT) != 0u;
    point.distance = hit.t.x * length(rough_direction(source));
    return point;
}

// A ray from a point in a direction of any length, which ends at `end` lengths of it.
fn spawn(point: Point, direction: Place3, end: Double) -> Ray {
    var out: Ray;
    let rough = rough_place(direction);
    let largest = largest_of(abs(rough));
    // A power of two, exactly.
    let exponent = clamp((bitcast<u32>(largest) >> 23u) & 255u, 1u, 253u);
    let scale = bitcast<f32>((254u - exponent) << 23u);
    out.origin = point.position;
    for (var k = 0u; k < 3u; k++) {
        out.direction[k] = direction[k] * scale;
    }
    out.t_max = end;
    if end.x < ENDLESS {
        // The other way round, exactly too.
        out.t_max = end * bitcast<f32>(exponent << 23u);
    }
    out.surface = point.surface;
    let front = dot(rough, point.geometric) >= 0.0;
    out.leaves = (point.wall << WALL_SHIFT) | select(0u, FRONT, front);
    out.line = point.line;
    out.time = time_now;
    out.zero = zero;
    out.exempt = NOTHING;
    out.any = 0u;
    return out;
}

fn spawn_along(point: Point, direction: vec3<f32>) -> Ray {
    let wide = Place3(double(direction.x), double(direction.y), double(direction.z));
    return spawn(point, wide, double(ENDLESS));
}

// A ray that meets nothing, at once.
fn no_ray() -> Ray {
    var out: Ray;
    out.direction[0] = double(1.0);
    out.t_max = double(-1.0);
    out.time = time_now;
    out.surface = NOTHING;
    out.exempt = NOTHING;
    out.zero = zero;
    return out;
}

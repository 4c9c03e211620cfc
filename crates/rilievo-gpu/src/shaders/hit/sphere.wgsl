// The twin of `relief/sphere/shading.rs`: points of displaced spheres. Differences of q are worked out from differences
// of heights, which floats hold.

struct Ball {
    center: Place3,
    // Distance from the centre at raw height 0, and its change for one raw unit.
    at_zero: Double,
    per_raw: Double,
    cells: u32,
    // Where the heights of its six maps begin; all else of them is the same.
    heights: array<u32, 6>,
}

var<private> ball: Ball;

fn ball_sign(side: u32) -> f32 {
    return select(1.0, -1.0, (side & 1u) == 1u);
}

// The axes across a face of the cube.
fn ball_across(side: u32) -> vec2<u32> {
    let axis = side / 2u;
    return vec2<u32>(select(0u, 1u, axis == 0u), select(2u, 1u, axis == 2u));
}

// A vector of which components across and along a face are known.
fn from_face(side: u32, v: vec3<f32>) -> vec3<f32> {
    let across = ball_across(side);
    var out: vec3<f32>;
    out[across.x] = v.x;
    out[across.y] = v.y;
    out[side / 2u] = ball_sign(side) * v.z;
    return out;
}

// The direction of a lattice point, up to length, and the length.
fn lattice_direction(at: vec2<u32>) -> vec3<f32> {
    let n = i32(ball.cells);
    return vec3<f32>(vec3<i32>(2 * vec2<i32>(at) - n, n));
}

fn ball_raw(side: u32, at: vec2<u32>) -> f32 {
    shown_map.heights = ball.heights[side];
    return raw(at.x, at.y);
}

// q of one lattice point less that of another, of directions d and e and raw heights a and b.
fn less_q(d: vec3<f32>, a: f32, e: vec3<f32>, b: f32) -> f32 {
    let ld = length(d);
    let le = length(e);
    let rd = ball.at_zero.x + ball.per_raw.x * a;
    let re = ball.at_zero.x + ball.per_raw.x * b;
    let squares = dot(d + e, d - e);
    return (squares / (ld + le) * re - le * (ball.per_raw.x * (a - b))) / (rd * re);
}

fn q_of(d: vec3<f32>, a: f32) -> f32 {
    return length(d) / (ball.at_zero.x + ball.per_raw.x * a);
}

// The normal of the gap at a lattice point inside a face.
fn face_normal(side: u32, at: vec2<u32>) -> vec3<f32> {
    let x = vec2<u32>(1u, 0u);
    let y = vec2<u32>(0u, 1u);
    let d = lattice_direction(at);
    let along_a = 0.25 * less_q(
        lattice_direction(at + x), ball_raw(side, at + x),
        lattice_direction(at - x), ball_raw(side, at - x),
    );
    let along_b = 0.25 * less_q(
        lattice_direction(at + y), ball_raw(side, at + y),
        lattice_direction(at - y), ball_raw(side, at - y),
    );
    let upright = (q_of(d, ball_raw(side, at)) - d.x * along_a - d.y * along_b) / d.z;
    return normalize(from_face(side, vec3<f32>(along_a, along_b, upright)));
}

// Position of a point of the cube on the surface, from the centre.
fn ball_position(at: vec3<u32>) -> vec3<f32> {
    let n = ball.cells;
    var side = 0u;
    for (var axis = 0u; axis < 3u; axis++) {
        if at[2u - axis] == 0u || at[2u - axis] == n {
            side = 2u * (2u - axis) + select(1u, 0u, at[2u - axis] == n);
        }
    }
    let across = ball_across(side);
    let height = ball_raw(side, vec2<u32>(at[across.x], at[across.y]));
    let along = vec3<f32>(2 * vec3<i32>(at) - i32(n));
    return along * ((ball.at_zero.x + ball.per_raw.x * height) / length(along));
}

// A step inward from the end of an axis.
fn inward_from(at: vec3<u32>, axis: u32) -> vec3<f32> {
    var next = at;
    next[axis] = select(at[axis] - 1u, 1u, at[axis] == 0u);
    return ball_position(next);
}

// The normal of a point of the cube.
fn vertex_normal(side: u32, at: vec2<u32>) -> vec3<f32> {
    let n = ball.cells;
    let x_edge = at.x == 0u || at.x == n;
    let y_edge = at.y == 0u || at.y == n;
    if !x_edge && !y_edge {
        return face_normal(side, at);
    }
    let across = ball_across(side);
    var place: vec3<u32>;
    place[across.x] = at.x;
    place[across.y] = at.y;
    place[side / 2u] = select(n, 0u, (side & 1u) == 1u);
    let outward = vec3<f32>(2 * vec3<i32>(place) - i32(n));
    var normal: vec3<f32>;
    if x_edge && y_edge {
        let here = ball_position(place);
        let a = inward_from(place, 0u) - here;
        let b = inward_from(place, 1u) - here;
        let c = inward_from(place, 2u) - here;
        normal = cross(a, b) + cross(b, c) + cross(c, a);
    } else {
        let along = select(across.x, across.y, x_edge);
        var before = place;
        var after = place;
        before[along] -= 1u;
        after[along] += 1u;
        let a = inward_from(place, (along + 1u) % 3u);
        let b = inward_from(place, (along + 2u) % 3u);
        normal = cross(a - b, ball_position(after) - ball_position(before));
    }
    normal = unit_or(normal, vec3<f32>(0.0));
    return select(normal, -normal, dot(normal, outward) < 0.0);
}

fn point_of_relief_sphere(hit: Hit, form: u32, first_face: u32) -> Point {
    var point: Point;
    ball.center = place_in_scene(form);
    ball.at_zero = double_in_scene(form + 6u);
    ball.per_raw = double_in_scene(form + 8u);
    ball.cells = scene[form + 10u];
    show(first_face);
    for (var k = 0u; k < 6u; k++) {
        ball.heights[k] = faces[first_face + k].heights;
    }
    let n = i32(ball.cells);
    let side = (hit.part >> WALL_SHIFT) % 6u;
    let cell = min(vec2<u32>(hit.cell), vec2<u32>(ball.cells - 1u));
    let x = hit.local[0];
    let y = hit.local[1];
    var heights: array<f32, 4>;
    var q: array<Double, 4>;
    for (var k = 0u; k < 4u; k++) {
        let at = cell + vec2<u32>(k & 1u, k >> 1u);
        heights[k] = ball_raw(side, at);
        let along = 2 * vec2<i32>(at) - n;
        let square = u32(along.x * along.x + along.y * along.y + n * n);
        let whole = quick_two_sum(f32(square & 0xfffff000u), f32(square & 0xfffu));
        let radius = sum(ball.at_zero, scaled(ball.per_raw, heights[k]));
        q[k] = ratio(root(whole), radius);
    }
    let low = sum(q[0], product(x, difference(q[1], q[0])));
    let high = sum(q[2], product(x, difference(q[3], q[2])));
    let value = sum(low, product(y, difference(high, low)));
    let a = sum(scaled(sum(double(f32(cell.x)), x), 2.0), double(-f32(n)));
    let b = sum(scaled(sum(double(f32(cell.y)), y), 2.0), double(-f32(n)));
    let across = ball_across(side);
    var arm: Place3;
    arm[across.x] = ratio(a, value);
    arm[across.y] = ratio(b, value);
    arm[side / 2u] = ratio(double(f32(n) * ball_sign(side)), value);
    for (var k = 0u; k < 3u; k++) {
        point.position[k] = sum(ball.center[k], arm[k]);
    }
    var ways: array<vec3<f32>, 4>;
    for (var k = 0u; k < 4u; k++) {
        ways[k] = lattice_direction(cell + vec2<u32>(k & 1u, k >> 1u));
    }
    let along_a = 0.5 * (less_q(ways[1], heights[1], ways[0], heights[0]) * (1.0 - y.x)
        + less_q(ways[3], heights[3], ways[2], heights[2]) * y.x);
    let along_b = 0.5 * (less_q(ways[2], heights[2], ways[0], heights[0]) * (1.0 - x.x)
        + less_q(ways[3], heights[3], ways[1], heights[1]) * x.x);
    let upright = (value.x - a.x * along_a - b.x * along_b) / f32(n);
    point.geometric = normalize(from_face(side, vec3<f32>(along_a, along_b, upright)));
    point.shading = point.geometric;
    if scene[form + 11u] != 0u {
        var normals: array<vec3<f32>, 4>;
        for (var k = 0u; k < 4u; k++) {
            normals[k] = vertex_normal(side, cell + vec2<u32>(k & 1u, k >> 1u));
        }
        let lower = mix(normals[0], normals[1], x.x);
        let upper = mix(normals[2], normals[3], x.x);
        let normal = unit_or(mix(lower, upper, y.x), vec3<f32>(0.0, 0.0, 1.0));
        point.shading = select(point.geometric, normal, dot(normal, point.geometric) > 0.0);
    }
    add_spherical(&point, number(form + 12u), unit_or(rough_place(arm), vec3<f32>(0.0, 0.0, 1.0)));
    return point;
}

// The twin of `relief/mesh/wall.rs` in doubles: what closes a mesh where the two sides of an edge show
// different heights.

// By how much a wall is longer than its edge, and higher than its sides, as a fraction.
const OVERLAP: f32 = 3.7252903e-9;

// The kind of wall in `leaves` and `part`.
const SEAM_WALL: u32 = 7u;

// Height over the level that a side of an edge shows at a place along it.
fn side_height(place: u32, s: Double) -> Double {
    var cell: vec2<i32>;
    var at: array<Double, 2>;
    for (var k = 0u; k < 2u; k++) {
        let a = number_at(place + 2u * k);
        let x = sum(a, product(s, difference(number_at(place + 4u + 2u * k), a)));
        let line = round(x.x);
        var first = floored(x);
        // On a line between cells, the cell on the side's own side.
        if abs(difference(x, double(line)).x) <= 1e-9 {
            first = select(line, line - 1.0, float_at(place + 8u + k) < 0.0);
        }
        cell[k] = i32(first);
        at[k] = difference(x, double(first));
    }
    return height_of(heights_over(unfolded_corners(cell)), at[0], at[1]);
}

// The height of the mesh that a side of an edge of another part shows, which is told of at a place of `numbers`.
fn height_beside(part: u32, side: u32, s: Double) -> Double {
    let own_face = face;
    let own_level = relief_mesh.level;
    show(numbers[part]);
    relief_mesh.level = float_at(part + 1u);
    let height = side_height(side, s);
    show(own_face);
    relief_mesh.level = own_level;
    return sum(product(height, number_at(part + 2u)), number_at(part + 4u));
}

// Heights of both sides of the wall at a place of `numbers`.
fn wall_heights(place: u32, s: Double) -> array<Double, 2> {
    var heights: array<Double, 2>;
    heights[1] = relief_mesh.base;
    let own = 1u + numbers[place + 3u];
    let beside = numbers[place + 24u];
    let sides = select(own, 1u, beside != NOTHING);
    for (var k = 0u; k < sides; k++) {
        heights[k] = side_height(place + 4u + 10u * k, s);
    }
    if beside != NOTHING {
        heights[1] = height_beside(beside, place + 14u, s);
    }
    return heights;
}

fn cross_double(ax: Double, ay: Double, bx: Double, by: Double) -> Double {
    return difference(product(ax, by), product(ay, bx));
}

// A vector from `numbers`, less another, in floats.
fn between_places(a: u32, b: u32) -> vec3<f32> {
    var v: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        v[k] = difference(number_at(b + 2u * k), number_at(a + 2u * k));
    }
    return in_floats(v);
}

fn rise_of(vertex: u32) -> vec3<f32> {
    return vec3<f32>(
        float_at(vertex + 6u),
        float_at(vertex + 8u),
        float_at(vertex + 10u),
    );
}

// The normal of a wall at a place along its edge and a height, towards the side that is lower.
fn wall_normal(place: u32, s: f32, height: f32, first_is_higher: bool) -> vec3<f32> {
    let a = vertex_place(numbers[place]);
    let b = vertex_place(numbers[place + 1u]);
    let edge = between_places(a, b);
    let turn = between_places(a + 6u, b + 6u);
    let outward = cross(edge + height * turn, rise_of(a) + s * turn);
    return select(-outward, outward, first_is_higher);
}

// Where the ray meets a wall.
fn meet_wall(number: u32) {
    steps += 1u;
    let place = relief_mesh.walls + WALL_WORDS * number;
    var corners: array<array<Double, 3>, 4>;
    for (var k = 0u; k < 4u; k++) {
        let vertex = vertex_place(numbers[place + (k & 1u)]);
        corners[k] = sheared_vector(vertex + 6u * (k >> 1u), k < 2u);
    }
    let p = corners[0];
    let n = corners[2];
    var edge: array<Double, 3>;
    var turn: array<Double, 3>;
    var size = 0.0;
    var steep = 0.0;
    for (var k = 0u; k < 3u; k++) {
        edge[k] = difference(corners[1][k], p[k]);
        turn[k] = difference(corners[3][k], n[k]);
        size = max(size, max(abs(p[k].x), abs(corners[1][k].x)));
        steep = max(steep, max(abs(n[k].x), abs(corners[3][k].x)));
    }
    let c0 = cross_double(p[0], p[1], n[0], n[1]);
    let c1 = sum(cross_double(p[0], p[1], turn[0], turn[1]), cross_double(edge[0], edge[1], n[0], n[1]));
    let c2 = cross_double(edge[0], edge[1], turn[0], turn[1]);
    let rounding = 16.0 * DOUBLE_ROUNDING * size * steep;
    let discriminant = difference(product(c1, c1), scaled(product(c0, c2), 4.0));
    if discriminant.x < -8.0 * rounding * (abs(c0.x) + abs(c1.x) + abs(c2.x)) {
        return;
    }
    var r = root(discriminant);
    if c1.x < 0.0 {
        r = -r;
    }
    let q = scaled(sum(c1, r), -0.5);
    for (var k = 0u; k < 2u; k++) {
        var above = c0;
        var under = q;
        if k == 1u {
            above = q;
            under = c2;
        }
        // An endless place or 0/0.
        if !(abs(under.x) * 1e3 > abs(above.x) * 0.5) || under.x == 0.0 {
            continue;
        }
        var s = ratio(above, under);
        let slope = abs(c1.x + 2.0 * c2.x * s.x);
        let error = OVERLAP + select(min(rounding / slope, 1e-6), 1e-6, slope <= 0.0);
        if s.x < -error || difference(s, double(1.0)).x > error {
            continue;
        }
        s = smaller_double(larger_double(s, double(0.0)), double(1.0));
        var at: array<Double, 3>;
        var rise: array<Double, 3>;
        for (var m = 0u; m < 3u; m++) {
            at[m] = sum(p[m], product(s, edge[m]));
            rise[m] = sum(n[m], product(s, turn[m]));
        }
        let square = sum(product(rise[0], rise[0]), product(rise[1], rise[1]));
        let towards = sum(product(at[0], rise[0]), product(at[1], rise[1]));
        if square.x <= 0.0 {
            continue;
        }
        let height = -ratio(towards, square);
        let ends = wall_heights(place, s);
        let high = larger_double(ends[0], ends[1]);
        let low = smaller_double(ends[0], ends[1]);
        let between = difference(high, low).x;
        let slack = OVERLAP * (relief_mesh.half_range + between)
            + 32.0 * DOUBLE_ROUNDING * size / sqrt(square.x) + error * between;
        if difference(height, low).x < -slack || difference(height, high).x > slack {
            continue;
        }
        let t = ratio(sum(at[2], product(height, rise[2])), along);
        let nearer = below(t, mesh_limit)
            || (mesh_hit.surface == NOTHING && at_most(t, mesh_limit));
        let normal = wall_normal(place, s.x, height.x, !below(ends[0], ends[1]));
        let front = dot(normal, in_floats(mesh_direction)) < 0.0;
        if t.x >= 0.0 && nearer && (front || !relief_mesh.one_sided) {
            mesh_limit = t;
            mesh_hit.t = t;
            mesh_hit.local[0] = s;
            mesh_hit.local[1] = height;
            mesh_hit.cell = vec2<i32>(0);
            mesh_hit.part = (SEAM_WALL << WALL_SHIFT) | select(0u, FRONT, front);
            mesh_hit.piece = number;
            mesh_hit.surface = 0u;
        }
    }
}

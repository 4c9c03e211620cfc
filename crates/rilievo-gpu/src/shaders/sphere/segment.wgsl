// The twin of `relief/sphere/segment.rs` in doubles: a ray over one face of the cube, straight in (x, y, q).

// A slope that is not 0, and leads nowhere.
const STILL: f32 = 1e-25;

// A point over a face of the cube: cells' coordinates and q.
struct Over {
    face: u32,
    at: array<Double, 2>,
    q: Double,
}

struct SphereSegment {
    face: u32,
    // Cells' coordinates at s = 0, slope and reciprocal slope, neither 0.
    origin: array<Double, 2>,
    slope: array<Double, 2>,
    inverse: array<Double, 2>,
    // q at s = 0 and its change.
    q: Double,
    dq: Double,
    // Gaps at both ends, the same for both segments that meet there.
    gaps: array<Double, 2>,
    // Parameters of the ray at both ends, from the start of its part.
    t: array<Double, 2>,
}

var<private> segment: SphereSegment;

// The axes across a face of the cube.
fn across(cube_face: u32, k: u32) -> u32 {
    let axis = cube_face / 2u;
    if k == 0u {
        return select(0u, 1u, axis == 0u);
    }
    return select(2u, 1u, axis == 2u);
}

fn sign_of(cube_face: u32) -> f32 {
    return select(1.0, -1.0, (cube_face & 1u) == 1u);
}

// The face of the cube through which a direction goes.
fn face_towards(v: array<Double, 3>) -> u32 {
    let x = magnitude(v[0]);
    let y = magnitude(v[1]);
    let z = magnitude(v[2]);
    var axis = 2u;
    var along = v[2];
    if at_most(y, x) && at_most(z, x) {
        axis = 0u;
        along = v[0];
    } else if at_most(z, y) {
        axis = 1u;
        along = v[1];
    }
    return 2u * axis + select(0u, 1u, along.x < 0.0);
}

// A point of the ray at a distance z along a face, as it sees it; on the edge to another face, if there
// is one, its coordinate is set.
fn over_face(cube_face: u32, point: array<Double, 3>, z: Double, other: u32) -> Over {
    var seen: Over;
    seen.face = cube_face;
    let n = double(f32(radii.cells));
    for (var k = 0u; k < 2u; k++) {
        let axis = across(cube_face, k);
        if other != NOTHING && axis == other / 2u {
            seen.at[k] = n;
            if (other & 1u) == 1u {
                seen.at[k] = double(0.0);
            }
        } else {
            let a = sum(ratio(point[axis], z), double(1.0));
            let cells = scaled(a, 0.5 * n.x);
            seen.at[k] = smaller_double(larger_double(cells, double(0.0)), n);
        }
    }
    seen.q = ratio(scaled(radii.middle, n.x), z);
    return seen;
}

// The gap at a point over a face of the cube.
fn gap_over(seen: Over) -> Double {
    show(radii.faces + seen.face);
    var cell: vec2<u32>;
    var local: array<Double, 2>;
    for (var k = 0u; k < 2u; k++) {
        cell[k] = min(u32(floored(seen.at[k])), radii.cells - 1u);
        local[k] = difference(seen.at[k], double(f32(cell[k])));
    }
    let surface = bilinear_double(radii_corners(cell), local[0], local[1]);
    return difference(surface, seen.q);
}

// The segment between two points that one face of the cube sees.
fn make_segment(start: Over, end: Over) {
    segment.face = start.face;
    segment.origin = start.at;
    segment.q = start.q;
    segment.dq = difference(end.q, start.q);
    for (var k = 0u; k < 2u; k++) {
        var slope = difference(end.at[k], start.at[k]);
        if abs(slope.x) < STILL {
            // On the last line there is a cell on one side only.
            let on_last = slope.x == 0.0 && start.at[k].x >= f32(radii.cells);
            slope = double(select(STILL, -STILL, slope.x < 0.0 || on_last));
        }
        segment.slope[k] = slope;
        let inverse = ratio(double(1.0), slope);
        // Away from 0, so that the border of a face lies at 1 or beyond.
        segment.inverse[k] = sum(inverse, scaled(inverse, 2.2737368e-13));
    }
}

fn segment_crosses(axis: u32, line: f32) -> Double {
    return product(difference(double(line), segment.origin[axis]), segment.inverse[axis]);
}

fn segment_q(s: Double) -> Double {
    return sum(segment.q, product(s, segment.dq));
}

// The ray's parameter at s, from the start of its part.
fn segment_t(s: Double) -> Double {
    let fraction = ratio(product(s, sum(segment.q, segment.dq)), segment_q(s));
    return sum(segment.t[0], product(fraction, difference(segment.t[1], segment.t[0])));
}

// s at a parameter of the ray, kept in [0, 1].
fn segment_s(t: Double) -> f32 {
    if at_most(t, segment.t[0]) {
        return 0.0;
    }
    if at_most(segment.t[1], t) {
        return 1.0;
    }
    let before = difference(t, segment.t[0]).x * segment.q.x;
    let after = difference(segment.t[1], t).x * (segment.q.x + segment.dq.x);
    return before / (before + after);
}

fn segment_local(axis: u32, cell: u32, s: Double) -> Double {
    let from_corner = difference(segment.origin[axis], double(f32(cell)));
    let local = sum(from_corner, product(s, segment.slope[axis]));
    return smaller_double(larger_double(local, double(0.0)), double(1.0));
}

// The first root in a cell; its place is in s of the segment.
fn segment_meet(cell: vec2<u32>) -> GapRoot {
    var none: GapRoot;
    none.found = false;
    var near: array<Double, 2>;
    var far: array<Double, 2>;
    for (var k = 0u; k < 2u; k++) {
        let forward = segment.slope[k].x > 0.0;
        let line = f32(cell[k]);
        near[k] = segment_crosses(k, select(line + 1.0, line, forward));
        far[k] = segment_crosses(k, select(line, line + 1.0, forward));
    }
    let s0 = larger_double(larger_double(near[0], near[1]), double(0.0));
    let s1 = smaller_double(smaller_double(far[0], far[1]), double(1.0));
    if at_most(s1, s0) {
        return none;
    }
    // Where the ray enters and leaves the cell, by axis.
    var places: array<array<Double, 2>, 2>;
    for (var k = 0u; k < 2u; k++) {
        let ahead = select(0.0, 1.0, segment.slope[k].x > 0.0);
        places[0][k] = double(1.0 - ahead);
        if below(near[k], s0) {
            places[0][k] = segment_local(k, cell[k], s0);
        }
        places[1][k] = double(ahead);
        if below(s1, far[k]) {
            places[1][k] = segment_local(k, cell[k], s1);
        }
    }
    let corners = radii_corners(cell);
    var surface: array<Double, 4>;
    for (var k = 0u; k < 4u; k++) {
        surface[k] = bilinear_double(corners, places[k & 1u][0], places[k >> 1u][1]);
    }
    let qa = segment_q(s0);
    let qb = segment_q(s1);
    var b0 = difference(surface[0], qa);
    var b2 = difference(surface[3], qb);
    if is_zero(s0) {
        b0 = segment.gaps[0];
    }
    if s1.x == 1.0 && s1.y == 0.0 {
        b2 = segment.gaps[1];
    }
    let b1 = scaled(difference(sum(surface[1], surface[2]), sum(qa, qb)), 0.5);
    var found = first_root_double(b0, b1, b2);
    let s = sum(s0, product(found.at, difference(s1, s0)));
    found.at = smaller_double(s, s1);
    return found;
}

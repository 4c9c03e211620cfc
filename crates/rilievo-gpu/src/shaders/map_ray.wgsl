// The twin of `relief/map_ray.rs`, `relief/shell.rs` and `Placement::map_ray`: a ray is brought into
// lattice space, cut to the face's box and rounded into the forward frame of the walk. Everything
// before the last rounding is in doubles.

// A ray in lattice space, unrounded; its parameter runs from 0 to 1 over the part in the face's box.
struct ExactRay {
    origin: array<Double, 3>,
    direction: array<Double, 3>,
    t_start: Double,
    t_length: Double,
}

struct MapRay {
    o: vec2<f32>,
    d: vec2<f32>,
    inv: vec2<f32>,
    oz: f32,
    dz: f32,
    base: vec2<i32>,
    // -1 along an axis on which cells are counted backward, else 0.
    turn: vec2<i32>,
    lo: vec2<f32>,
    hi: vec2<f32>,
    cull: vec2<f32>,
    above: bool,
}

// What of a face its map decides. It is read once, when the face is turned to: a walk asks for it at every step.
struct ShownMap {
    low: f32,
    high: f32,
    size: f32,
    code_base: f32,
    code_step: f32,
    raw_zero: f32,
    flags: u32,
    samples: vec2<u32>,
    cells: vec2<u32>,
    texel: u32,
    wrap: u32,
    heights: u32,
    bounds: u32,
    levels: u32,
    distance: u32,
}

// The face at hand, the ray in its frame, and the work done so far.
var<private> face: u32;
var<private> shown_map: ShownMap;
var<private> exact: ExactRay;
var<private> ray: MapRay;
var<private> steps: u32;
// Whether the ray leaves this very surface.
var<private> spawned: bool;

// Turns to a face.
fn show(number: u32) {
    face = number;
    shown_map.low = faces[number].low;
    shown_map.high = faces[number].high;
    shown_map.size = faces[number].size;
    shown_map.code_base = faces[number].code_base;
    shown_map.code_step = faces[number].code_step;
    shown_map.raw_zero = faces[number].raw_zero;
    shown_map.flags = faces[number].flags;
    shown_map.samples = faces[number].samples;
    shown_map.cells = faces[number].cells;
    shown_map.texel = faces[number].texel;
    shown_map.wrap = faces[number].wrap;
    shown_map.heights = faces[number].heights;
    shown_map.bounds = faces[number].bounds;
    shown_map.levels = faces[number].levels;
    shown_map.distance = faces[number].distance;
}

fn has(flag: u32) -> bool {
    return (shown_map.flags & flag) != 0u;
}

// Row k of the matrix times a vector.
fn transformed(k: u32, v: array<Double, 3>) -> Double {
    let m0 = faces[face].lattice_from_world[3u * k];
    let m1 = faces[face].lattice_from_world[3u * k + 1u];
    let m2 = faces[face].lattice_from_world[3u * k + 2u];
    return sum(sum(product(m0, v[0]), product(m1, v[1])), product(m2, v[2]));
}

// How far from the surface a ray starts that leaves it, raw heights.
fn lift_of(leaves: u32) -> f32 {
    let lift = faces[face].lift;
    let up = ((leaves & FRONT) != 0u) == has(RISES);
    return select(-lift, lift, up);
}

// Sets `ray` and `exact`; false if the ray passes by the face's box.
fn prepare(source: Ray, t_max: Double, number: u32) -> bool {
    var from_corner: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        from_corner[k] = difference(source.origin[k], faces[face].corner[k]);
    }
    var origin: array<Double, 3>;
    var direction: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        origin[k] = sum(transformed(k, from_corner), faces[face].lattice_corner[k]);
        direction[k] = transformed(k, source.direction);
    }
    var lift = 0.0;
    spawned = source.surface == number;
    if spawned {
        let wall = source.leaves >> WALL_SHIFT;
        if wall == 0u {
            lift = lift_of(source.leaves);
        } else if wall > 4u {
            origin[wall - 5u] = double(f32(source.line));
        } else {
            // A straight line crosses the border's line only once.
            let axis = (wall - 1u) / 2u;
            let high = ((wall - 1u) & 1u) == 1u;
            if (high && direction[axis].x >= 0.0) || (!high && direction[axis].x <= 0.0) {
                return false;
            }
            origin[axis] = faces[face].window_low[axis];
            if high {
                origin[axis] = faces[face].window_high[axis];
            }
        }
    }
    return clip(origin, direction, lift, t_max);
}

// Cuts the ray to the box; see `relief/shell.rs`.
fn clip(origin: array<Double, 3>, direction: array<Double, 3>, lift: f32, t_max: Double) -> bool {
    var enter = double(0.0);
    var leave = double(3e38);
    var inv_z: Double;
    var o = origin;
    var d = direction;
    for (var k = 0u; k < 3u; k++) {
        let inv = reciprocal(d[k]);
        let a = product(difference(faces[face].shell_low[k], o[k]), inv);
        let b = product(difference(faces[face].shell_high[k], o[k]), inv);
        enter = larger_double(smaller_double(a, b), enter);
        leave = smaller_double(larger_double(a, b), leave);
        inv_z = inv;
    }
    if !(below(enter, leave) && at_most(enter, t_max)) || leave.x > 1e37 {
        return false;
    }
    let length = difference(leave, enter);
    let part = ratio(double(1.0), length);
    var end = 1.0;
    if below(t_max, leave) {
        let own = product(difference(t_max, enter), part);
        // In doubles as all before the last rounding: fixed steps divide what lies before it.
        end = smaller(sum(sum(own, scaled(own, 1e-6)), double(1e-9)).x, 1.0);
    }
    for (var k = 0u; k < 3u; k++) {
        exact.origin[k] = sum(o[k], product(enter, d[k]));
        exact.direction[k] = product(d[k], length);
    }
    exact.t_start = enter;
    exact.t_length = length;
    let z = sum(exact.origin[2], double(lift));
    let scale = product(inv_z, part);
    let c = product(difference(faces[face].culled[0], z), scale);
    let e = product(difference(faces[face].culled[1], z), scale);
    ray.cull.x = larger(next_down(smaller(c.x, e.x)), 0.0);
    ray.cull.y = smaller(next_up(smaller(larger(c.x, e.x), end)), 1.0);
    ray.oz = z.x;
    ray.dz = exact.direction[2].x;
    ray.above = lift > 0.0 || below(double(shown_map.high), exact.origin[2]);
    round_axis(0u);
    round_axis(1u);
    return true;
}

// Rounds one axis of the exact ray into the forward frame.
fn round_axis(axis: u32) {
    let origin = exact.origin[axis];
    let direction = exact.direction[axis];
    var near = faces[face].window_low[axis];
    var far = faces[face].window_high[axis];
    // A ray in the plane of the far border is counted backward too: borders are closed.
    let on_far = direction.x == 0.0 && origin.x == far.x && origin.y == far.y;
    let backward = direction.x < 0.0 || on_far;
    var start = origin;
    if backward {
        start = -origin;
        let low = near;
        near = -far;
        far = -low;
    }
    let base = floored(start);
    ray.o[axis] = difference(start, double(base)).x;
    ray.d[axis] = abs(direction.x);
    ray.inv[axis] = quotient(1.0, larger(ray.d[axis], 1e-30));
    ray.base[axis] = i32(select(base, -base, backward));
    ray.turn[axis] = select(0, -1, backward);
    ray.lo[axis] = difference(near, double(base)).x;
    ray.hi[axis] = difference(far, double(base)).x;
}

// Parameter at which the ray meets a line of an axis.
fn time_of(axis: u32, line: f32) -> f32 {
    return rounded(line - ray.o[axis]) * ray.inv[axis];
}

fn near_line(axis: u32, f: i32) -> f32 {
    return larger(f32(f), ray.lo[axis]);
}

fn far_line(axis: u32, f: i32) -> f32 {
    return smaller(f32(f + 1), ray.hi[axis]);
}

fn height_at(s: f32) -> f32 {
    return rounded(s * ray.dz) + ray.oz;
}

fn first_cell(axis: u32) -> i32 {
    return i32(floor(ray.lo[axis]));
}

fn end_cell(axis: u32) -> i32 {
    return i32(ceil(ray.hi[axis]));
}

// The forward cell f of the window with T(f) <= s < T(f + 1), or the nearest one.
fn cell_at(axis: u32, s: f32) -> i32 {
    let first = first_cell(axis);
    let last = end_cell(axis) - 1;
    var f = clamp(i32(floor(ray.o[axis] + s * ray.d[axis])), first, last);
    while f > first && time_of(axis, f32(f)) > s {
        f -= 1;
    }
    while f < last && time_of(axis, f32(f + 1)) <= s {
        f += 1;
    }
    return f;
}

// The forward cell f of the window with T(f) < s <= T(f + 1).
fn cell_before(axis: u32, s: f32) -> i32 {
    var f = cell_at(axis, s);
    while f > first_cell(axis) && time_of(axis, f32(f)) >= s {
        f -= 1;
    }
    return f;
}

// The unfolded cell behind a forward cell.
fn unfolded(axis: u32, f: i32) -> i32 {
    return select(ray.base[axis] + f, ray.base[axis] - 1 - f, ray.turn[axis] != 0);
}

fn unfolded_line(axis: u32, f: i32) -> i32 {
    return select(ray.base[axis] + f, ray.base[axis] - f, ray.turn[axis] != 0);
}

// The twin of `relief/refine.rs` in doubles: the root on the unrounded ray. Steps shorter than 1e-9
// of a cell count as none, where the CPU asks for 1e-12.

struct Root {
    s: Double,
    cell: vec2<i32>,
    local: array<Double, 2>,
    // Where the root leads out of the cell, and the window goes on: the cell there.
    beyond: vec2<i32>,
    leads_on: bool,
}

// The patch h00 + b x + c y + d x y of a cell, all four exact to a few units of 2^-48.
struct Patch {
    h: Double,
    b: Double,
    c: Double,
    d: Double,
}

fn patch_of(h: vec4<f32>) -> Patch {
    let b = difference(double(h.y), double(h.x));
    let c = difference(double(h.z), double(h.x));
    let d = difference(difference(double(h.w), double(h.z)), b);
    return Patch(double(h.x), b, c, d);
}

fn patch_height(p: Patch, x: Double, y: Double) -> Double {
    let low = sum(p.h, product(p.b, x));
    return sum(low, product(sum(p.c, product(p.d, x)), y));
}

fn point_at(k: u32, s: Double) -> Double {
    return sum(exact.origin[k], product(s, exact.direction[k]));
}

// Gap between the unrounded ray and the surface under it.
fn gap_at(s: Double) -> Double {
    let x = point_at(0u, s);
    let y = point_at(1u, s);
    let i = floored(x);
    let j = floored(y);
    let h = patch_of(unfolded_corners(vec2<i32>(i32(i), i32(j))));
    let under = patch_height(h, difference(x, double(i)), difference(y, double(j)));
    return difference(point_at(2u, s), under);
}

// Step from s0 to the root of a cell's patch nearest to it, or to the closest approach; not before
// the start.
fn step_to_root(p: Patch, x: Double, y: Double, s0: Double) -> Double {
    let dx = exact.direction[0];
    let dy = exact.direction[1];
    let dz = exact.direction[2];
    let g0 = difference(point_at(2u, s0), patch_height(p, x, y));
    let along_x = product(sum(p.b, product(p.d, y)), dx);
    let along_y = product(sum(p.c, product(p.d, x)), dy);
    let g1 = difference(dz, sum(along_x, along_y));
    let g2 = -product(product(p.d, dx), dy);
    let discriminant = difference(product(g1, g1), product(double(4.0), product(g2, g0)));
    var above = -g1;
    var under = scaled(g2, 2.0);
    if discriminant.x >= 0.0 {
        let r = root(discriminant);
        above = -scaled(g0, 2.0);
        under = sum(g1, select(r, -r, g1.x < 0.0));
    }
    // An endless step or 0/0.
    if !(abs(under.x) > abs(above.x) * 1e-30) || under.x == 0.0 {
        return double(0.0);
    }
    return larger_double(ratio(above, under), -s0);
}

// Keeps a local coordinate inside cell and window.
fn inside(axis: u32, cell: i32, local: Double) -> Double {
    let corner = double(f32(cell));
    let low = larger_double(difference(faces[face].window_low[axis], corner), double(0.0));
    let high = smaller_double(difference(faces[face].window_high[axis], corner), double(1.0));
    return larger_double(smaller_double(local, high), low);
}

fn root_near(cell: vec2<i32>, s0: Double) -> Root {
    var found: Root;
    let p = patch_of(unfolded_corners(cell));
    var at: array<Double, 2>;
    for (var k = 0u; k < 2u; k++) {
        at[k] = difference(point_at(k, s0), double(f32(cell[k])));
    }
    var kept = step_to_root(p, at[0], at[1], s0);
    found.cell = cell;
    found.leads_on = false;
    for (var k = 0u; k < 2u; k++) {
        let end = sum(at[k], product(kept, exact.direction[k]));
        let line = inside(k, cell[k], end);
        if abs(difference(end, line).x) <= 1e-9 {
            continue;
        }
        let to_line = ratio(difference(line, at[k]), exact.direction[k]);
        let on_the_way = to_line.x * kept.x >= 0.0 && abs(to_line.x) <= abs(kept.x);
        if on_the_way || abs(to_line.x) <= 1e-6 {
            kept = to_line;
        }
        let rises = below(line, end);
        found.beyond = cell;
        found.beyond[k] += select(-1, 1, rises);
        let border = double(f32(cell[k] + select(0, 1, rises)));
        found.leads_on = select(
            below(faces[face].window_low[k], border),
            below(border, faces[face].window_high[k]),
            rises,
        );
    }
    for (var k = 0u; k < 2u; k++) {
        found.local[k] = inside(k, cell[k], sum(at[k], product(kept, exact.direction[k])));
    }
    found.s = sum(s0, kept);
    return found;
}

// The crossing near s0, first in a cell, then in the neighbours the root leads to.
fn root_across(cell: vec2<i32>, s0: f32) -> Root {
    let home = root_near(cell, double(s0));
    var next = home;
    for (var k = 0; k < 2; k++) {
        if !next.leads_on {
            return next;
        }
        next = root_near(next.beyond, next.s);
    }
    if next.leads_on {
        return home;
    }
    return next;
}

// Whether the unrounded ray may cross the surface near s0 from the given side.
fn crosses(s0: f32, from_above: bool) -> bool {
    let range = larger(shown_map.high - shown_map.low, 1e-37);
    let across = larger(abs(exact.direction[0].x), abs(exact.direction[1].x));
    let speed = larger(across, abs(exact.direction[2].x) / range);
    let step = double(0.000244140625 / speed);
    let before = gap_at(difference(double(s0), step)).x;
    let after = gap_at(sum(double(s0), step)).x;
    if from_above {
        return !(before < 0.0 && after > 0.0);
    }
    return !(before > 0.0 && after < 0.0);
}

// Whether the unrounded ray starts beyond the crossing that the leaf found, with no root after it. A ray
// that leaves the surface starts on it, to rounding; where that is a crease, the sign of the gap means
// nothing below 2^-30 of the map's size, and the crossing is kept: nothing slips through.
fn starts_beyond(cell: vec2<i32>, s0: f32, from_above: bool) -> bool {
    let gap = gap_at(double(0.0)).x;
    let least = select(0.0, shown_map.size * 9.3e-10, spawned);
    let beyond = select(gap > least, gap < -least, from_above);
    return beyond && root_near(cell, double(s0)).s.x <= 0.0;
}

// Whether the unrounded ray bears out what the leaf found in a span that begins at t0.
fn confirms(t0: f32, hit: LeafHit, admit: u32) -> bool {
    if t0 == 0.0 {
        let cell = vec2<i32>(unfolded(0u, hit.cell.x), unfolded(1u, hit.cell.y));
        if starts_beyond(cell, hit.s, hit.from_above) {
            return false;
        }
    }
    return admit == BOTH || crosses(hit.s, hit.from_above);
}

// The twin of `relief/approximate.rs`: methods that look at points of the ray, never at the cells between them, and
// miss. Method `march` in doubles; the paper's is in `published`.

// See the constant of the CPU.
const MARCH_STEPS: u32 = 64u;

// Where an approximate method believes the ray meets the surface.
struct PointHit {
    found: bool,
    s: Double,
    from_above: bool,
}

// The hit of the face at hand at a point, up to the ray's end.
fn hit_at_point(met: PointHit, t_max: Double, number: u32) -> Hit {
    var hit: Hit;
    hit.surface = NOTHING;
    if !met.found {
        return hit;
    }
    for (var k = 0u; k < 2u; k++) {
        let x = point_at(k, met.s);
        hit.cell[k] = i32(cell_in_window(k, floored(x)));
        hit.local[k] = difference(x, double(f32(hit.cell[k])));
    }
    hit.t = sum(exact.t_start, product(met.s, exact.t_length));
    if below(t_max, hit.t) {
        return hit;
    }
    hit.surface = number;
    hit.part = select(0u, FRONT, met.from_above == has(RISES));
    return hit;
}

// The part of the ray in the face's window and the map's height range, and the ends of that range through which it
// comes in and goes out, where it does not do so through a side or end before.
struct MarchSpan {
    begin: Double,
    end: Double,
    enters: bool,
    exits: bool,
    ends: vec2<f32>,
}

fn march_span() -> MarchSpan {
    var at: MarchSpan;
    at.end = double(ray.cull.y);
    for (var k = 0u; k < 3u; k++) {
        let o = exact.origin[k];
        let d = exact.direction[k];
        var low = double(shown_map.low);
        var high = double(shown_map.high);
        if k < 2u {
            low = faces[face].window_low[k];
            high = faces[face].window_high[k];
        }
        if is_zero(d) {
            if below(o, low) || below(high, o) {
                at.end = double(-1.0);
            }
            continue;
        }
        let a = ratio(difference(low, o), d);
        let b = ratio(difference(high, o), d);
        let near = smaller_double(a, b);
        let far = larger_double(a, b);
        at.enters = k == 2u && below(at.begin, near);
        at.exits = k == 2u && below(far, at.end);
        at.ends = vec2<f32>(shown_map.low, shown_map.high);
        if d.x < 0.0 {
            at.ends = at.ends.yx;
        }
        at.begin = larger_double(at.begin, near);
        at.end = smaller_double(at.end, far);
    }
    return at;
}

// The unfolded cell of the window that holds a coordinate: on the window's border the one inside, where rounding would
// choose between two tiles that may not meet.
fn cell_in_window(axis: u32, x: f32) -> f32 {
    let first = floored(faces[face].window_low[axis]);
    let last = -floored(-faces[face].window_high[axis]) - 1.0;
    return max(min(x, last), first);
}

// Raw height of the surface under or above a point of the ray.
fn height_under(s: Double) -> Double {
    let x = point_at(0u, s);
    let y = point_at(1u, s);
    let i = cell_in_window(0u, floored(x));
    let j = cell_in_window(1u, floored(y));
    let h = patch_of(unfolded_corners(vec2<i32>(i32(i), i32(j))));
    return patch_height(h, difference(x, double(i)), difference(y, double(j)));
}

fn march_gap(s: Double) -> Double {
    return difference(point_at(2u, s), height_under(s));
}

// The gap where the ray passes an end of the height range: its sign is that of no rounding.
fn gap_at_end(s: Double, end: f32) -> Double {
    let under = height_under(s);
    let kept = larger_double(smaller_double(under, double(shown_map.high)), double(shown_map.low));
    return difference(double(end), kept);
}

// Fixed steps to the first change of side, then one secant.
fn march_fixed() -> PointHit {
    var hit: PointHit;
    let span = march_span();
    var begin = span.begin;
    if below(span.end, begin) {
        return hit;
    }
    if spawned {
        // Its own start is not to be found: half a cell on.
        let speed = larger_double(magnitude(exact.direction[0]), magnitude(exact.direction[1]));
        var half_cell = difference(span.end, begin);
        if speed.x > 0.0 {
            half_cell = ratio(double(0.5), speed);
        }
        begin = sum(begin, half_cell);
    }
    let step = scaled(difference(span.end, begin), 1.0 / f32(MARCH_STEPS));
    if step.x < 0.0 {
        return hit;
    }
    var last = begin;
    var last_gap = march_gap(begin);
    hit.from_above = last_gap.x > 0.0;
    // The highest and lowest places touch the ends of the range, where the ray comes in and goes out.
    if span.enters && !spawned {
        hit.from_above = exact.direction[2].x < 0.0;
        if is_zero(gap_at_end(begin, span.ends.x)) {
            hit.s = begin;
            hit.found = true;
        }
    }
    for (var k = 1u; k <= MARCH_STEPS && !hit.found; k++) {
        steps += 1u;
        let s = sum(begin, scaled(step, f32(k)));
        let exits = span.exits && k == MARCH_STEPS;
        var gap: Double;
        if exits {
            gap = gap_at_end(s, span.ends.y);
        } else {
            gap = march_gap(s);
        }
        if exits && is_zero(gap) {
            hit.s = s;
            hit.found = true;
        } else if (gap.x > 0.0) != hit.from_above {
            let part = ratio(last_gap, difference(last_gap, gap));
            hit.s = sum(last, product(difference(s, last), part));
            hit.found = true;
        }
        last = s;
        last_gap = gap;
    }
    hit.found = hit.found && admits(admitted(), hit.from_above);
    return hit;
}

// What fixed steps meet, as a hit of the face at hand, up to the ray's end.
fn meet_marched(t_max: Double, number: u32) -> Hit {
    return hit_at_point(march_fixed(), t_max, number);
}

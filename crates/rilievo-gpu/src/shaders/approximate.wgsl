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
        hit.cell[k] = i32(floored(x));
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

// The part of the ray in the face's window and the map's height range, and the end of that range through which it
// comes in.
struct MarchSpan {
    begin: Double,
    end: Double,
    enters: bool,
    entry: f32,
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
        at.enters = k == 2u && below(at.begin, near);
        at.entry = select(shown_map.low, shown_map.high, d.x < 0.0);
        at.begin = larger_double(at.begin, near);
        at.end = smaller_double(at.end, larger_double(a, b));
    }
    return at;
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
    var last_gap = gap_at(begin);
    hit.from_above = last_gap.x > 0.0;
    if span.enters && !spawned {
        // The highest and lowest places touch the ends of the range, where the ray comes in.
        hit.from_above = exact.direction[2].x < 0.0;
        let towards = difference(point_at(2u, begin), double(span.entry));
        if is_zero(difference(last_gap, towards)) {
            hit.s = begin;
            hit.found = true;
        }
    }
    for (var k = 1u; k <= MARCH_STEPS && !hit.found; k++) {
        steps += 1u;
        let s = sum(begin, scaled(step, f32(k)));
        let gap = gap_at(s);
        if (gap.x > 0.0) != hit.from_above {
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

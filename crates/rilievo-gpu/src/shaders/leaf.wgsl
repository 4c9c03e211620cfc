// The twin of `relief/leaf.rs`, operation by operation, so that its bits are the CPU's.

const BOTH: u32 = 0u;
const DOWNWARD: u32 = 1u;
const UPWARD: u32 = 2u;

// Which crossings of the raw surface are hits.
fn admitted() -> u32 {
    if !has(ONE_SIDED) {
        return BOTH;
    }
    return select(UPWARD, DOWNWARD, has(RISES));
}

fn admits(admit: u32, from_above: bool) -> bool {
    return admit == BOTH || (admit == DOWNWARD) == from_above;
}

// Slack of every bound test, raw units.
fn slack() -> f32 {
    return shown_map.size * 9.5367431640625e-7;
}

fn lerp(a: f32, b: f32, t: f32) -> f32 {
    return rounded(t * b) + rounded(a - rounded(t * a));
}

fn bilinear(h: vec4<f32>, x: f32, y: f32) -> f32 {
    return lerp(lerp(h.x, h.z, y), lerp(h.y, h.w, y), x);
}

// Local coordinate along an axis at s, not set by a line.
fn local_at(axis: u32, f: f32, s: f32) -> f32 {
    return smaller(larger(rounded(s * ray.d[axis]) - rounded(f - ray.o[axis]), 0.0), 1.0);
}

// Local coordinate where the ray enters a cell, set on the near line if that gave the parameter.
fn entering(axis: u32, f: i32, s: f32) -> f32 {
    let line = near_line(axis, f);
    return select(local_at(axis, f32(f), s), line - f32(f), time_of(axis, line) >= s);
}

fn leaving(axis: u32, f: i32, s: f32) -> f32 {
    let line = far_line(axis, f);
    return select(local_at(axis, f32(f), s), line - f32(f), time_of(axis, line) <= s);
}

// Gap between ray and surface in Bernstein form, over the part of the ray from t0 to t1.
struct Gap {
    b0: f32,
    b1: f32,
    b2: f32,
}

fn gap_of(near: vec2<f32>, far: vec2<f32>, t0: f32, t1: f32, h: vec4<f32>) -> Gap {
    let za = rounded(height_at(t0));
    let zb = rounded(height_at(t1));
    let low = lerp(lerp(h.x, h.z, near.y), lerp(h.y, h.w, near.y), near.x);
    let high = lerp(lerp(h.x, h.z, far.y), lerp(h.y, h.w, far.y), far.x);
    let across = rounded(bilinear(h, near.x, far.y)) + rounded(bilinear(h, far.x, near.y));
    return Gap(za - rounded(low), (rounded(za + zb) - rounded(across)) * 0.5, zb - rounded(high));
}

struct LeafHit {
    found: bool,
    s: f32,
    // Forward cell.
    cell: vec2<i32>,
    from_above: bool,
}

fn no_hit() -> LeafHit {
    return LeafHit(false, 0.0, vec2<i32>(0), false);
}

// The first admitted root, as a fraction of the span in `s`.
fn first_root(gap: Gap, admit: u32) -> LeafHit {
    var hit = no_hit();
    // A ray that starts on the surface came from the side it does not go to.
    let above = gap.b0 > 0.0
        || (gap.b0 == 0.0 && (gap.b1 < 0.0 || (gap.b1 == 0.0 && gap.b2 < 0.0)));
    let sign = select(-1.0, 1.0, above);
    let b0 = sign * gap.b0;
    let b1 = sign * gap.b1;
    let b2 = sign * gap.b2;
    let discriminant = rounded(b1 * b1) - rounded(b0 * b2);
    let dips = b1 < 0.0 && discriminant >= 0.0;
    if !(b0 == 0.0 || b2 <= 0.0 || dips) {
        return hit;
    }
    let root = sqrt(larger(discriminant, 0.0));
    if admits(admit, above) {
        hit.found = true;
        hit.from_above = above;
        if b0 == 0.0 {
            hit.s = 0.0;
        } else if b1 <= 0.0 {
            hit.s = b0 / (b0 - b1 + root);
        } else {
            hit.s = (b1 + root) / (b1 + root - b2);
        }
    } else if b2 > 0.0 && dips {
        // The other direction counts: the second root, where the ray comes back.
        hit.found = true;
        hit.from_above = !above;
        hit.s = (root - b1) / (root - b1 + b2);
    }
    return hit;
}

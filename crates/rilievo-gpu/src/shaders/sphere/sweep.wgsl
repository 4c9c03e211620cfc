// The twin of `relief/sphere/sweep.rs`: a segment against the children of a node, or the cells of a block, in
// floats. Its slacks are sixteen times what it rounds, so fusing changes no answer.

// By how much lines are moved outward, cells, and intervals are widened, in s.
const BESIDE_CELL: f32 = 1.1920929e-7;
const BESIDE_PART: f32 = 4.7683716e-7;

struct Sweep {
    // All ones for a mirrored axis.
    turn: vec2<i32>,
    // The mirrored cell that holds the start.
    base: vec2<i32>,
    near: vec2<f32>,
    far: vec2<f32>,
    inverse: vec2<f32>,
    // Where the segment is closest to the centre, and how far to look.
    nearest: f32,
    end: f32,
    outside: bool,
    // Whether the higher bounds decide.
    upper: bool,
    // (N^2 - m^2 q^2) / n^2 and m q / n, by powers of s.
    level: vec3<f32>,
    q: vec2<f32>,
    slack: f32,
    at_zero: f32,
    per_raw: f32,
}

var<private> sweep: Sweep;

fn make_sweep(outside: bool, nearest: f32, end: f32) {
    let n = f32(radii.cells);
    // a^2, a b and b^2 of both coordinates a + b s, which count from -1 to 1, and of q.
    var square: array<Double, 3>;
    square[0] = double(1.0);
    square[1] = double(0.0);
    square[2] = double(0.0);
    for (var k = 0u; k < 3u; k++) {
        var a = ratio(segment.q, double(n));
        var b = ratio(segment.dq, double(n));
        if k < 2u {
            let backward = segment.slope[k].x < 0.0;
            sweep.turn[k] = select(0, -1, backward);
            var start = segment.origin[k];
            if backward {
                start = -start;
            }
            let first = floored(start);
            sweep.base[k] = i32(first);
            let left = difference(start, double(first)).x;
            sweep.near[k] = left + BESIDE_CELL;
            sweep.far[k] = left - BESIDE_CELL;
            sweep.inverse[k] = min(abs(segment.inverse[k].x), 1e25);
            a = difference(ratio(scaled(segment.origin[k], 2.0), double(n)), double(1.0));
            b = ratio(scaled(segment.slope[k], 2.0), double(n));
        }
        let sign = select(-1.0, 1.0, k < 2u);
        square[0] = sum(square[0], sign * product(a, a));
        square[1] = sum(square[1], (2.0 * sign) * product(a, b));
        square[2] = sum(square[2], sign * product(b, b));
    }
    sweep.level = vec3<f32>(square[0].x, square[1].x, square[2].x);
    let q0 = segment.q.x / n;
    let dq = segment.dq.x / n;
    sweep.q = vec2<f32>(q0, dq);
    let most = max(q0, q0 + dq) * max(q0, q0 + dq);
    sweep.at_zero = difference(radii.at_zero, double(1.0)).x;
    sweep.per_raw = radii.per_raw.x;
    let height = abs(sweep.at_zero) + abs(sweep.per_raw * radii.largest_raw);
    let magnitudes = abs(sweep.level);
    let size = magnitudes.x + magnitudes.y + magnitudes.z + 2.0 * height * (1.0 + height) * most;
    sweep.slack = 1.9073486e-6 * size + select(radii.beneath * most, radii.above, outside);
    sweep.outside = outside;
    sweep.upper = outside == (radii.per_raw.x > 0.0);
    sweep.nearest = nearest;
    sweep.end = end + BESIDE_PART;
}

fn sweep_at(s: f32) -> vec2<f32> {
    let level = (s * sweep.level.z + sweep.level.y) * s + sweep.level.x;
    return vec2<f32>(level, s * sweep.q.y + sweep.q.x);
}

// Where the segment is over a square of `side` cells from a mirrored cell on.
fn sweep_over(corner: vec2<i32>, side: f32) -> vec2<f32> {
    let first = vec2<f32>(corner - sweep.base);
    let near = (first - sweep.near) * sweep.inverse - BESIDE_PART;
    let far = (first + side - sweep.far) * sweep.inverse + BESIDE_PART;
    return vec2<f32>(max(max(near.x, near.y), 0.0), min(min(far.x, far.y), sweep.end));
}

// Whether the segment may meet there, over a part of it, a surface of this highest or lowest raw height.
fn sweep_reaches(over: vec2<f32>, height: f32) -> bool {
    let enter = min(over.x, 1.0 + BESIDE_PART);
    let leave = max(over.y, 0.0);
    let above = height * sweep.per_raw + sweep.at_zero;
    let limit = above * (above + 2.0);
    if sweep.outside {
        let at = sweep_at(min(max(sweep.nearest, enter), leave));
        return at.x <= limit * (at.y * at.y) + sweep.slack;
    }
    let a = sweep_at(enter);
    let b = sweep_at(leave);
    return limit * (a.y * a.y) <= a.x + sweep.slack || limit * (b.y * b.y) <= b.x + sweep.slack;
}

// The children that the ray may meet of a node, mirrored, that stands on the map.
fn sweep_node(level: u32, node: vec2<i32>) -> u32 {
    let at = vec2<u32>(node ^ sweep.turn);
    let table = shown_map.bounds + 3u * level;
    let side = select(2u, 1u, sweep.upper);
    let codes = bound_word(table + side) + (at.y * bound_word(table) + at.x) * 8u;
    let mirror = vec2<u32>(sweep.turn) & vec2<u32>(3u);
    let shift = vec2<u32>(2u * level + 2u);
    var mask = 0u;
    for (var lane = 0u; lane < 16u; lane++) {
        let place = vec2<u32>(lane & 3u, lane >> 2u);
        let over = sweep_over((4 * node + vec2<i32>(place)) << shift, f32(4u << (2u * level)));
        if over.x > over.y {
            continue;
        }
        let stored = place ^ mirror;
        let pair = bound_word(codes + stored.y * 2u + (stored.x >> 1u));
        let code = select(pair & 0xffffu, pair >> 16u, (stored.x & 1u) == 1u);
        let height = shown_map.code_base + f32(code) * shown_map.code_step;
        mask |= select(0u, 1u << lane, sweep_reaches(over, height));
    }
    return mask;
}

// Whether the segment may meet the surface in a cell, mirrored.
fn sweep_cell(cell: vec2<i32>) -> bool {
    let over = sweep_over(cell, 1.0);
    if over.x > over.y {
        return false;
    }
    let at = vec2<u32>(cell ^ sweep.turn);
    let h = vec4<f32>(
        raw(at.x, at.y),
        raw(at.x + 1u, at.y),
        raw(at.x, at.y + 1u),
        raw(at.x + 1u, at.y + 1u),
    );
    let lowest = min(min(h.x, h.y), min(h.z, h.w));
    let highest = max(max(h.x, h.y), max(h.z, h.w));
    return sweep_reaches(over, select(lowest, highest, sweep.upper));
}

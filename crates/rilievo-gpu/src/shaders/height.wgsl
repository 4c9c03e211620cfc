// The twin of `map/height.rs` and `map/lattice.rs`: samples, what stored cells join, and how a map
// unfolds.

// Raw value of a sample.
fn raw(i: u32, j: u32) -> f32 {
    let at = j * shown_map.samples.x + i;
    if has(FLOATS) {
        return bitcast<f32>(height_word(shown_map.heights + at));
    }
    let pair = height_word(shown_map.heights + (at >> 1u));
    return f32(select(pair & 0xffffu, pair >> 16u, (at & 1u) == 1u));
}

// Whether stored cell 0 begins a cell before sample 0.
fn is_padded() -> bool {
    return shown_map.wrap == CLAMP || (shown_map.texel == 1u && shown_map.wrap == MIRROR);
}

// The two samples that a stored cell joins.
fn joined(axis: u32, cell: i32) -> vec2<u32> {
    let last = i32(shown_map.samples[axis]) - 1;
    if is_padded() {
        return vec2<u32>(vec2<i32>(clamp(cell - 1, 0, last), clamp(cell, 0, last)));
    }
    let c = clamp(cell, 0, last);
    return vec2<u32>(vec2<i32>(c, select(0, c + 1, c < last)));
}

// Corners h00, h10, h01, h11 of a stored cell, seen from its other end where an axis is turned.
fn corners_of(cell: vec2<i32>, turn: vec2<i32>) -> vec4<f32> {
    var x = joined(0u, cell.x);
    var y = joined(1u, cell.y);
    x = select(x, x.yx, turn.x != 0);
    y = select(y, y.yx, turn.y != 0);
    return vec4<f32>(raw(x.x, y.x), raw(x.y, y.x), raw(x.x, y.y), raw(x.y, y.y));
}

// A run of unfolded cells that shows stored cells in order, or falling where `flipped` is -1.
struct Run {
    start: i32,
    len: i32,
    first: i32,
    flipped: i32,
}

fn floor_div(a: i32, b: i32) -> i32 {
    return a / b - select(0, 1, a % b < 0);
}

// The run that holds an unfolded cell.
fn run_of(axis: u32, i: i32) -> Run {
    let n = i32(shown_map.samples[axis]);
    let texel = shown_map.texel == 1u;
    if shown_map.wrap == CLAMP {
        if i < -1 {
            return Run(i, 1, 0, 0);
        }
        if i > n - 1 {
            return Run(i, 1, n, 0);
        }
        return Run(-1, n + 1, 0, 0);
    }
    let p = select(n - 1, n, texel);
    if shown_map.wrap == REPEAT {
        return Run(floor_div(i, p) * p, p, 0, 0);
    }
    let pad = select(0, 1, texel);
    let k = floor_div(i + pad, p);
    let flipped = (k & 1) == 1;
    return Run(k * p - pad, p, select(0, select(p - 1, n, texel), flipped), select(0, -1, flipped));
}

fn stored(run: Run, i: i32) -> i32 {
    return select(run.first + (i - run.start), run.first - (i - run.start), run.flipped != 0);
}

// Corners of an unfolded cell.
fn unfolded_corners(cell: vec2<i32>) -> vec4<f32> {
    let x = run_of(0u, cell.x);
    let y = run_of(1u, cell.y);
    let at = vec2<i32>(stored(x, cell.x), stored(y, cell.y));
    return corners_of(at, vec2<i32>(x.flipped, y.flipped));
}

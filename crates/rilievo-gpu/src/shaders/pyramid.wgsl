// The twin of `map/pyramid/blocks.rs` and `map/pyramid/build.rs`: bounds from heights, and bounds from
// bounds. One invocation makes one word of maxima and one of minima: two blocks side by side.
// Samples are compared as keys (`samples`); only codes of floats need arithmetic, and comparisons prove what it gives.

// What one dispatch makes.
struct Task {
    samples: vec2<u32>,
    // Stored cells along each axis.
    cells: vec2<u32>,
    // 1 where stored cell 0 begins a cell before sample 0.
    padded: u32,
    // 1 for heights in floats.
    floats: u32,
    // First word of the samples.
    heights: u32,
    // Always 0, which no compiler knows; see `rounded`.
    zero: u32,
    // Words along x and block rows to make: the first, and one past the last.
    first: vec2<u32>,
    end: vec2<u32>,
    // Nodes along x of the level that is made, first words of its maxima and minima.
    across: u32,
    maxima: u32,
    minima: u32,
    unused: u32,
    // The level below it: nodes, first words of maxima and minima.
    below: vec2<u32>,
    below_maxima: u32,
    below_minima: u32,
    // Value of code 0, and of one code step.
    code_base: f32,
    code_step: f32,
    unused_pair: vec2<u32>,
}

@group(0) @binding(0) var<storage, read> task: Task;

// Maximum and minimum of a lane beyond the map.
const NO_MAXIMUM: u32 = 0u;
const NO_MINIMUM: u32 = 0xffffu;

// Where the words of two blocks lie, counted from the first maximum or minimum.
fn word_of(at: vec2<u32>) -> u32 {
    let node = (at.y >> 2u) * task.across + (at.x >> 1u);
    return node * 8u + (at.y & 3u) * 2u + (at.x & 1u);
}

fn store_pair(at: vec2<u32>, maxima: vec2<u32>, minima: vec2<u32>) {
    let word = word_of(at);
    set_bound_word(task.maxima + word, maxima.x | (maxima.y << 16u));
    set_bound_word(task.minima + word, minima.x | (minima.y << 16u));
}

fn value_of(key: u32) -> f32 {
    return bitcast<f32>(bits_of(key));
}

// The key of a code's value.
fn code_key(code: i32) -> u32 {
    let value = task.code_base + rounded(f32(code) * task.code_step);
    return key_of_bits(bitcast<u32>(rounded(value)));
}

// The code near a value; nothing more is promised.
fn code_near(value: f32) -> i32 {
    return i32(clamp((value - task.code_base) / task.code_step + 0.5, 0.0, 65535.0));
}

// The first code, up to 65536, whose value has this key or one above it.
fn first_code(key: u32) -> i32 {
    var first = 0;
    var end = 65536;
    while first < end {
        let middle = (first + end) / 2;
        if code_key(middle) >= key {
            end = middle;
        } else {
            first = middle + 1;
        }
    }
    return first;
}

// Maximum and minimum in codes: see `Code::encode`. Where a first guess is not proven, all codes are searched.
fn encoded(low: u32, high: u32) -> vec2<u32> {
    if task.floats == 0u {
        return vec2<u32>(high, low);
    }
    if task.code_step > 0.0 {
        var down = code_near(value_of(low));
        var up = code_near(value_of(high));
        down -= select(0, 1, code_key(down) > low);
        up += select(0, 1, code_key(up) < high);
        let down_right = down >= 0 && code_key(down) <= low && code_key(down + 1) > low;
        let up_right = up <= 65535 && code_key(up) >= high && (up == 0 || code_key(up - 1) < high);
        if down_right && up_right {
            return vec2<u32>(u32(up), u32(down));
        }
    }
    let last = first_code(high);
    let first = max(first_code(low + 1u), 1) - 1;
    return vec2<u32>(u32(last), u32(min(first, last)));
}

// Two blocks of the finest level, from nine lines of five samples.
@compute @workgroup_size(8, 8)
fn ground(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = task.first + id.xy;
    if at.x >= task.end.x || at.y >= task.end.y {
        return;
    }
    zero = task.zero;
    var maxima = vec2<u32>(NO_MAXIMUM);
    var minima = vec2<u32>(NO_MINIMUM);
    let corner = vec2<u32>(8u * at.x, 4u * at.y);
    if corner.x < task.cells.x && corner.y < task.cells.y {
        var rows: array<u32, 5>;
        for (var k = 0u; k < 5u; k++) {
            rows[k] = sample_of(1u, min(corner.y + k, task.cells.y));
        }
        var low = vec2<u32>(0xffffffffu);
        var high = vec2<u32>(0u);
        for (var k = 0u; k < 9u; k++) {
            let column = sample_of(0u, min(corner.x + k, task.cells.x));
            var lowest = 0xffffffffu;
            var highest = 0u;
            for (var row = 0u; row < 5u; row++) {
                let key = key_of(column, rows[row]);
                lowest = min(lowest, key);
                highest = max(highest, key);
            }
            if k <= 4u {
                low.x = min(low.x, lowest);
                high.x = max(high.x, highest);
            }
            if k >= 4u {
                low.y = min(low.y, lowest);
                high.y = max(high.y, highest);
            }
        }
        let near = encoded(low.x, high.x);
        maxima.x = near.x;
        minima.x = near.y;
        if corner.x + 4u < task.cells.x {
            let far = encoded(low.y, high.y);
            maxima.y = far.x;
            minima.y = far.y;
        }
    }
    store_pair(at, maxima, minima);
}

// Highest maximum and lowest minimum of a node of the level below.
fn range_below(node: vec2<u32>) -> vec2<u32> {
    var found = vec2<u32>(NO_MAXIMUM, NO_MINIMUM);
    if node.x >= task.below.x || node.y >= task.below.y {
        return found;
    }
    let first = (node.y * task.below.x + node.x) * 8u;
    for (var k = 0u; k < 8u; k++) {
        let top = bound_word(task.below_maxima + first + k);
        let bottom = bound_word(task.below_minima + first + k);
        found.x = max(found.x, max(top & 0xffffu, top >> 16u));
        found.y = min(found.y, min(bottom & 0xffffu, bottom >> 16u));
    }
    return found;
}

// Two blocks of a coarser level: the ranges of two nodes.
@compute @workgroup_size(8, 8)
fn coarser(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = task.first + id.xy;
    if at.x >= task.end.x || at.y >= task.end.y {
        return;
    }
    let near = range_below(vec2<u32>(2u * at.x, at.y));
    let far = range_below(vec2<u32>(2u * at.x + 1u, at.y));
    store_pair(at, vec2<u32>(near.x, far.x), vec2<u32>(near.y, far.y));
}

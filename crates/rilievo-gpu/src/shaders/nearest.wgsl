// The twin of `map/distance/exact.rs` and `map/distance/published.rs`: the distance from a node of a distance map to the surface, or to
// its samples, as far as it takes to know its code. Nodes of the pyramid and the blocks of cells below are passed over by floats, cells are met in
// doubles; what neither can tell is left to the CPU, so that codes are the CPU's.
//
// Lengths are shares of the depth of the map, and points count from the node: numbers are as small as the distance.

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
    // Nodes of the distance map.
    size: vec3<u32>,
    // First node of this dispatch, and one past the last.
    first: u32,
    end: u32,
    // Levels of the pyramid.
    levels: u32,
    // 1 for distances to samples alone.
    published: u32,
    // The highest code.
    most: u32,
    // Value of a bound's code 0, and of one code step; what bounds are widened by.
    code_base: f32,
    code_step: f32,
    wider: f32,
    // A distance of `above` and c steps is coded c, unless it is within these shares of a step of the next one or of its own.
    before_next: f32,
    after_own: f32,
    // The first node of the chunk.
    chunk: u32,
    // Lengths of a cell and of a raw height.
    metric: array<Double, 3>,
    // The least distance that is surely coded 0 steps, and the length of one step.
    above: Double,
    step: Double,
}

@group(0) @binding(0) var<storage, read> task: Task;
// Where nodes lie along each axis: in stored cells, and raw heights.
@group(0) @binding(1) var<storage, read> places: array<Double>;
// The code of each node of a chunk, or `UNKNOWN`.
@group(0) @binding(2) var<storage, read_write> codes: array<u32>;

const UNKNOWN: u32 = 0xffffffffu;

// Levels a map of 2^24 cells a side has.
const LEVELS: u32 = 12u;
// A patch is halved at most this often.
const HALVINGS: u32 = 16u;
// Blocks and patches after which a search is left to the CPU.
const LONGEST: u32 = 16384u;

// What squared distances in floats are off by, and more.
const LESS: f32 = 0.99999;

// The node, the shortest squared distance so far, and one from which on nothing is worth a look, in floats too.
var<private> node: array<Double, 3>;
var<private> shortest: Double;
var<private> limit: Double;
var<private> coarse_limit: f32;
// Steps of a code; and whether its code is known to be 0.
var<private> code: u32;
var<private> near_enough: bool;
var<private> work: u32;

// From the node, along an axis, to a number that is a float.
fn towards(axis: u32, x: f32) -> Double {
    return product(difference(double(x), node[axis]), task.metric[axis]);
}

fn coarsely_towards(axis: u32, x: f32) -> f32 {
    return (rounded(x - node[axis].x) - node[axis].y) * task.metric[axis].x;
}

fn squared(v: array<Double, 3>) -> Double {
    return sum(sum(product(v[0], v[0]), product(v[1], v[1])), product(v[2], v[2]));
}

// Takes a squared distance of the surface into account.
fn offer(square: Double) {
    if !below(square, shortest) {
        return;
    }
    shortest = square;
    limit = square;
    if task.published == 0u {
        // All that is at least as far as its code says has no other code.
        let over = difference(root(square), task.above);
        if over.x < 0.0 {
            near_enough = true;
            return;
        }
        let steps = floored(ratio(over, task.step));
        let kept = sum(scaled(task.step, steps), task.above);
        limit = smaller_double(product(kept, kept), square);
    }
    coarse_limit = limit.x / LESS;
}

fn height_of_sample(x: u32, y: u32) -> f32 {
    let key = key_of(sample_of(0u, x), sample_of(1u, y));
    return select(f32(key), bitcast<f32>(bits_of(key)), task.floats == 1u);
}

// A cell as patches of it are made.
struct Cell {
    at: vec2<u32>,
    // Height `h + b x + c y + d x y`, from the node.
    h: Double,
    b: Double,
    c: Double,
    d: Double,
}

fn cell_of(at: vec2<u32>) -> Cell {
    let h00 = towards(2u, height_of_sample(at.x, at.y));
    let h10 = towards(2u, height_of_sample(at.x + 1u, at.y));
    let h01 = towards(2u, height_of_sample(at.x, at.y + 1u));
    let h11 = towards(2u, height_of_sample(at.x + 1u, at.y + 1u));
    let b = difference(h10, h00);
    let c = difference(h01, h00);
    return Cell(at, h00, b, c, difference(difference(h11, h01), b));
}

// A point of a cell, from the node.
fn point_of(cell: Cell, u: f32, v: f32) -> array<Double, 3> {
    var point: array<Double, 3>;
    point[0] = product(difference(two_sum(f32(cell.at.x), u), node[0]), task.metric[0]);
    point[1] = product(difference(two_sum(f32(cell.at.y), v), node[1]), task.metric[1]);
    let along = sum(scaled(cell.b, u), scaled(sum(cell.c, scaled(cell.d, u)), v));
    point[2] = sum(cell.h, along);
    return point;
}

// The gap between zero and an interval, 0 where it holds zero.
fn gap_between(a: f32, b: f32) -> f32 {
    return max(max(min(a, b), -max(a, b)), 0.0);
}

// Whether a part of a cell, from (u, v) on, may hold what is worth a look; its nearest point is offered.
fn looks_into(cell: Cell, u: f32, v: f32, side: f32) -> bool {
    let p00 = point_of(cell, u, v);
    let p10 = point_of(cell, u + side, v);
    let p01 = point_of(cell, u, v + side);
    let p11 = point_of(cell, u + side, v + side);
    let z = vec4<f32>(p00[2].x, p10[2].x, p01[2].x, p11[2].x);
    let gap = vec3<f32>(
        gap_between(p00[0].x, p11[0].x),
        gap_between(p00[1].x, p11[1].x),
        gap_between(min(min(z.x, z.y), min(z.z, z.w)), max(max(z.x, z.y), max(z.z, z.w))),
    );
    if dot(gap, gap) > coarse_limit {
        return false;
    }
    // The nearest point of its parallelogram, in floats: any other one would be right, and slow.
    let side_u = vec2<f32>(p10[0].x - p00[0].x, 0.5 * ((z.y - z.x) + (z.w - z.z)));
    let side_v = vec2<f32>(p01[1].x - p00[1].x, 0.5 * ((z.z - z.x) + (z.w - z.y)));
    let corner = 0.25 * ((z.x + z.y) + (z.z + z.w)) - 0.5 * (side_u.y + side_v.y);
    let uu = dot(side_u, side_u);
    let vv = dot(side_v, side_v);
    let uv = side_u.y * side_v.y;
    let ru = -(p00[0].x * side_u.x + corner * side_u.y);
    let rv = -(p00[1].x * side_v.x + corner * side_v.y);
    let area = uu * vv - uv * uv;
    var best = vec2<f32>(ru * vv - rv * uv, rv * uu - ru * uv) / area;
    if !(all(best >= vec2<f32>(0.0)) && all(best <= vec2<f32>(1.0))) {
        var least = 3e38;
        for (var k = 0u; k < 4u; k++) {
            let end = f32(k >> 1u);
            var at = vec2<f32>(clamp((ru - uv * end) / uu, 0.0, 1.0), end);
            if (k & 1u) == 1u {
                at = vec2<f32>(end, clamp((rv - uv * end) / vv, 0.0, 1.0));
            }
            let value = at.x * (uu * at.x - 2.0 * ru) + at.y * (vv * at.y - 2.0 * rv)
                + 2.0 * uv * at.x * at.y;
            if value < least {
                least = value;
                best = at;
            }
        }
    }
    let near = point_of(cell, u + side * best.x, v + side * best.y);
    offer(squared(near));
    // The patch lies beyond the plane through the nearest of its corners across the direction to that point.
    let n = vec3<f32>(near[0].x, near[1].x, near[2].x);
    let first = smaller_double(along(p00, n), along(p10, n));
    let least = smaller_double(first, smaller_double(along(p01, n), along(p11, n)));
    if least.x <= 0.0 {
        return true;
    }
    var across: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        across[k] = double(n[k]);
    }
    return !at_most(product(limit, squared(across)), product(least, least));
}

fn along(p: array<Double, 3>, n: vec3<f32>) -> Double {
    return sum(sum(scaled(p[0], n.x), scaled(p[1], n.y)), scaled(p[2], n.z));
}

// Looks into a cell, and where that does not tell into its quarters, one after the other.
fn search_cell(at: vec2<u32>) {
    let cell = cell_of(at);
    var part = vec2<u32>(0u);
    var depth = 0u;
    loop {
        work += 1u;
        let side = 1.0 / f32(1u << depth);
        let into = looks_into(cell, f32(part.x) * side, f32(part.y) * side, side);
        if near_enough || work > LONGEST {
            return;
        }
        if into && depth < HALVINGS {
            part *= 2u;
            depth += 1u;
            continue;
        }
        if into {
            work = LONGEST + 1u;
            return;
        }
        // The next quarter of the same part, or of the nearest one around it that has any left.
        while depth > 0u && (part.x & part.y & 1u) == 1u {
            part /= 2u;
            depth -= 1u;
        }
        if depth == 0u {
            return;
        }
        let quarter = (part.x & 1u) + 2u * (part.y & 1u) + 1u;
        part = (part & vec2<u32>(~1u)) + vec2<u32>(quarter & 1u, quarter >> 1u);
    }
}

fn search_block(block: vec2<u32>) {
    let last = vec2<u32>(min(4u * block + 4u, task.cells));
    if task.published == 0u {
        for (var y = 4u * block.y; y < last.y; y++) {
            for (var x = 4u * block.x; x < last.x; x++) {
                search_cell(vec2<u32>(x, y));
                if near_enough {
                    return;
                }
            }
        }
        return;
    }
    for (var y = 4u * block.y; y <= last.y; y++) {
        let to_row = coarsely_towards(1u, f32(y));
        for (var x = 4u * block.x; x <= last.x; x++) {
            let height = height_of_sample(x, y);
            let coarse = vec3<f32>(coarsely_towards(0u, f32(x)), to_row, coarsely_towards(2u, height));
            if dot(coarse, coarse) > coarse_limit {
                continue;
            }
            var point: array<Double, 3>;
            point[0] = towards(0u, f32(x));
            point[1] = towards(1u, f32(y));
            point[2] = towards(2u, height);
            offer(squared(point));
        }
    }
}

// Whether a block of cells of a level may hold what is worth a look.
fn may_be_near(level: u32, block: vec2<u32>) -> bool {
    let side = 4u << (2u * level);
    let low = side * block;
    if any(low >= task.cells) {
        return false;
    }
    let high = min(low + side, task.cells);
    let table = 3u * level;
    let word = ((block.y >> 2u) * bound_word(table) + (block.x >> 2u)) * 8u
        + 2u * (block.y & 3u) + ((block.x & 3u) >> 1u);
    let shift = 16u * (block.x & 1u);
    let top = (bound_word(bound_word(table + 1u) + word) >> shift) & 0xffffu;
    let bottom = (bound_word(bound_word(table + 2u) + word) >> shift) & 0xffffu;
    let highest = task.code_base + f32(top) * task.code_step + task.wider;
    let lowest = task.code_base + f32(bottom) * task.code_step - task.wider;
    let gap = vec3<f32>(
        gap_between(coarsely_towards(0u, f32(low.x)), coarsely_towards(0u, f32(high.x))),
        gap_between(coarsely_towards(1u, f32(low.y)), coarsely_towards(1u, f32(high.y))),
        gap_between(coarsely_towards(2u, lowest), coarsely_towards(2u, highest)),
    );
    return dot(gap, gap) <= coarse_limit;
}

// Looks into all of the map, first where the node is.
fn search_map(home: vec2<u32>) {
    var nodes: array<vec2<u32>, LEVELS>;
    var next: array<u32, LEVELS>;
    let top = task.levels - 1u;
    var level = top;
    nodes[top] = vec2<u32>(0u);
    next[top] = 0u;
    loop {
        let turn = next[level];
        if turn >= 16u {
            if level == top {
                return;
            }
            level += 1u;
            continue;
        }
        next[level] = turn + 1u;
        let own = (home >> vec2<u32>(2u * level + 2u)) & vec2<u32>(3u);
        let block = 4u * nodes[level] + (own ^ vec2<u32>(turn & 3u, turn >> 2u));
        if !may_be_near(level, block) {
            continue;
        }
        work += 1u;
        if level == 0u {
            search_block(block);
            if near_enough || work > LONGEST {
                return;
            }
            continue;
        }
        level -= 1u;
        nodes[level] = block;
        next[level] = 0u;
    }
}

// The code of the shortest distance, where what it may be off by leaves no other one.
fn code_found() -> u32 {
    if near_enough {
        return 0u;
    }
    if work > LONGEST {
        return UNKNOWN;
    }
    let over = difference(root(shortest), task.above);
    if over.x < 0.0 {
        return 0u;
    }
    let steps = ratio(over, task.step);
    let whole = floored(steps);
    let before = difference(double(whole + 1.0), steps).x;
    if difference(steps, double(whole)).x <= task.after_own || before <= task.before_next {
        return UNKNOWN;
    }
    return min(u32(whole), task.most);
}

@compute @workgroup_size(64)
fn find_nearest(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = task.first + id.x;
    if at >= task.end {
        return;
    }
    zero = task.zero;
    let here = vec3<u32>(at % task.size.x, (at / task.size.x) % task.size.y, at / task.size.x / task.size.y);
    node[0] = places[here.x];
    node[1] = places[task.size.x + here.y];
    node[2] = places[task.size.x + task.size.y + here.z];
    shortest = double(3e38);
    near_enough = false;
    work = 0u;
    let home = min(vec2<u32>(u32(floored(node[0])), u32(floored(node[1]))), task.cells - 1u);
    // Straight up or down the surface is no farther than the map is deep.
    let cell = cell_of(home);
    let x = difference(node[0], double(f32(home.x)));
    let y = difference(node[1], double(f32(home.y)));
    let rise = sum(sum(cell.h, product(cell.b, x)), product(sum(cell.c, product(cell.d, x)), y));
    offer(product(rise, rise));
    if !near_enough {
        search_map(home);
    }
    codes[at - task.chunk] = code_found();
}

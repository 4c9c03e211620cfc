// The twin of `map/distance/boxes.rs`: distances from voxels to the boxes that hold the surface, counted in whole steps, code
// for code the CPU's. One axis is searched outward from each voxel, as far as steps alone do not cost more than what was
// found.

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
    // Codes that are not 0.
    codes: u32,
    // Voxels.
    size: vec3<u32>,
    // The first slab of this dispatch.
    first: u32,
    // Steps across one voxel along x and y.
    weights: array<Whole, 2>,
    // Scene units of one raw unit of height, and steps of one squared scene unit, as `f64`.
    height: Whole,
    per_unit: Whole,
    // The first row of voxels of this dispatch.
    row: u32,
}

@group(0) @binding(0) var<storage, read> task: Task;
// Raw heights where slabs begin and end, as `f64`; then the fewest steps of each code but 0.
@group(0) @binding(1) var<storage, read> tables: array<Whole>;
// Lowest and highest height of each column, as `f32`.
@group(0) @binding(2) var<storage, read_write> columns: array<vec2<u32>>;
// Squared distances in steps, slab by slab: those straight up or down, and those within a row.
@group(0) @binding(3) var<storage, read_write> rises: array<Whole>;
@group(0) @binding(4) var<storage, read_write> rows: array<Whole>;
// Two codes a word, rows filled up to whole words.
@group(0) @binding(5) var<storage, read_write> codes: array<u32>;

// The division of `cells` cells into n parts: the first cell of part i, and one past the last.
fn cells_of(axis: u32, i: u32) -> vec2<u32> {
    let n = task.size[axis];
    let each = task.cells[axis] / n;
    let rest = task.cells[axis] % n;
    return vec2<u32>(i * each + i * rest / n, (i + 1u) * each + ((i + 1u) * rest + n - 1u) / n);
}

fn float_bits(key: u32) -> u32 {
    if task.floats == 1u {
        return bits_of(key);
    }
    return bitcast<u32>(f32(key));
}

@compute @workgroup_size(8, 8)
fn find_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= task.size.x || id.y >= task.size.y {
        return;
    }
    let across = cells_of(0u, id.x);
    let along = cells_of(1u, id.y);
    var low = 0xffffffffu;
    var high = 0u;
    for (var y = along.x; y <= along.y; y++) {
        let row = sample_of(1u, y);
        for (var x = across.x; x <= across.y; x++) {
            let key = key_of(sample_of(0u, x), row);
            low = min(low, key);
            high = max(high, key);
        }
    }
    columns[id.y * task.size.x + id.x] = vec2<u32>(float_bits(low), float_bits(high));
}

// Where a voxel of this dispatch lies in `rises` and `rows`.
fn step_place(x: u32, y: u32, slab: u32) -> u32 {
    return (slab * task.size.y + y) * task.size.x + x;
}

@compute @workgroup_size(64)
fn find_rises(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= task.size.x {
        return;
    }
    let column = columns[id.y * task.size.x + id.x];
    let bottom = exact_of_double(tables[task.first + id.z]);
    let top = exact_of_double(tables[task.first + id.z + 1u]);
    var gap = exact_difference(exact_of_float(column.x), top);
    if gap.negative || is_none(gap) {
        gap = exact_difference(bottom, exact_of_float(column.y));
    }
    var found = Whole(0u);
    if !gap.negative && !is_none(gap) {
        let rise = exact_product(gap, exact_of_double(task.height));
        found = whole_part(exact_product(exact_product(rise, rise), exact_of_double(task.per_unit)));
    }
    rises[step_place(id.x, id.y, id.z)] = found;
}

@compute @workgroup_size(64)
fn find_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= task.size.x {
        return;
    }
    let here = step_place(id.x, task.row + id.y, id.z);
    var best = rises[here];
    // Of a voxel and its neighbours nothing is between.
    var cost = Whole(0u);
    var more = task.weights[0];
    for (var by = 1u; by < task.size.x && is_less(cost, best); by++) {
        if by <= id.x {
            best = least_of(best, plus(rises[here - by], cost));
        }
        if id.x + by < task.size.x {
            best = least_of(best, plus(rises[here + by], cost));
        }
        cost = plus(cost, more);
        more = plus(more, plus(task.weights[0], task.weights[0]));
    }
    rows[here] = best;
}

fn least_steps(x: u32, y: u32, slab: u32) -> Whole {
    let across = task.size.x;
    let here = step_place(x, y, slab);
    var best = rows[here];
    var cost = Whole(0u);
    var more = task.weights[1];
    for (var by = 1u; by < task.size.y && is_less(cost, best); by++) {
        if by <= y {
            best = least_of(best, plus(rows[here - by * across], cost));
        }
        if y + by < task.size.y {
            best = least_of(best, plus(rows[here + by * across], cost));
        }
        cost = plus(cost, more);
        more = plus(more, plus(task.weights[1], task.weights[1]));
    }
    return best;
}

// How many codes but 0 ask for no more steps.
fn code_of(steps: Whole) -> u32 {
    let before = task.size.z + 1u;
    var first = 0u;
    var end = task.codes;
    while first < end {
        let middle = (first + end) / 2u;
        if is_less(steps, tables[before + middle]) {
            end = middle;
        } else {
            first = middle + 1u;
        }
    }
    return first;
}

// Two codes side by side.
@compute @workgroup_size(64)
fn find_codes(@builtin(global_invocation_id) id: vec3<u32>) {
    let words = (task.size.x + 1u) / 2u;
    if id.x >= words {
        return;
    }
    let x = 2u * id.x;
    let y = task.row + id.y;
    var word = code_of(least_steps(x, y, id.z));
    if x + 1u < task.size.x {
        word |= code_of(least_steps(x + 1u, y, id.z)) << 16u;
    }
    codes[((task.first + id.z) * task.size.y + y) * words + id.x] = word;
}

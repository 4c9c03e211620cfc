// The twin of `relief/walk`: descent of the min-max pyramid, front to back, and the cells of a block
// in the order in which the ray meets them.

// Levels a map of 2^24 cells a side has.
const LEVELS: u32 = 12u;

// What the walk of one tile keeps.
struct Walk {
    tile: Tile,
    // Height at the start, less and plus the slack of the cull.
    low_start: f32,
    high_start: f32,
    // The part of the ray worth walking in this tile.
    enter: f32,
    leave: f32,
    // Whether the ray may start below the surface.
    both: bool,
}

// Parameters at which the ray meets four lines of an axis.
fn times_of(axis: u32, lines: vec4<f32>) -> vec4<f32> {
    return rounded_four(lines - ray.o[axis]) * ray.inv[axis];
}

// Four codes of two words, in the order in which a ray meets them.
fn four_codes(place: u32, mirror: u32) -> vec4<u32> {
    let a = bound_word(place);
    let b = bound_word(place + 1u);
    let codes = vec4<u32>(a & 0xffffu, a >> 16u, b & 0xffffu, b >> 16u);
    return select(codes, codes.wzyx, mirror != 0u);
}

fn values_of(codes: vec4<u32>) -> vec4<f32> {
    return shown_map.code_base + rounded_four(vec4<f32>(codes) * shown_map.code_step);
}

fn bits_of_four(flags: vec4<bool>) -> u32 {
    let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), flags);
    return bits.x | bits.y | bits.z | bits.w;
}

// The children that the ray may meet of the node of a level that holds a mirrored cell.
fn met(walk: Walk, level: u32, cell: vec2<i32>) -> u32 {
    steps += 1u;
    let shift = vec2<u32>(2u * level + 4u);
    let node = cell >> shift;
    let base = (node << shift) - walk.tile.origin;
    let side = i32(4u << (2u * level));
    let children = vec4<i32>(0, 1, 2, 3) * side;
    let near_x = times_of(0u, vec4<f32>(base.x + children));
    let far_x = times_of(0u, vec4<f32>(base.x + side + children));
    let at = vec2<u32>(node ^ walk.tile.turn);
    let table = shown_map.bounds + 3u * level;
    let index = (at.y * bound_word(table) + at.x) * 8u;
    let upper = bound_word(table + 1u) + index;
    let lower = bound_word(table + 2u) + index;
    let mirror = vec2<u32>(walk.tile.turn) & vec2<u32>(3u);
    let sinks = ray.dz < 0.0;
    var mask = 0u;
    for (var y = 0u; y < 4u; y++) {
        let line = base.y + i32(y) * side;
        let enter_row = larger(walk.enter, time_of(1u, f32(line)));
        let leave_row = smaller(walk.leave, time_of(1u, f32(line + side)));
        if enter_row >= leave_row {
            continue;
        }
        let near = larger_four(vec4<f32>(enter_row), near_x);
        let far = smaller_four(vec4<f32>(leave_row), far_x);
        let row = (y ^ mirror.y) * 2u;
        let highest = values_of(four_codes(upper + row, mirror.x));
        let lowest_ray = rounded_four(select(near, far, sinks) * ray.dz) + walk.low_start;
        var meets = (near < far) & (lowest_ray <= highest);
        if walk.both {
            let lowest = values_of(four_codes(lower + row, mirror.x));
            let highest_ray = rounded_four(select(far, near, sinks) * ray.dz) + walk.high_start;
            meets = meets & (lowest <= highest_ray);
        }
        mask |= bits_of_four(meets) << (4u * y);
    }
    return mask;
}

// Parameters at which the ray enters and leaves a row of cells of a tile.
fn row_enter(walk: Walk, fy: i32) -> f32 {
    return larger(time_of(1u, larger(f32(fy), walk.tile.lo.y)), 0.0);
}

fn row_leave(walk: Walk, fy: i32) -> f32 {
    return smaller(time_of(1u, smaller(f32(fy + 1), walk.tile.hi.y)), 1.0);
}

// The first admitted crossing in the block with its corner at a mirrored cell.
fn first_in_block(walk: Walk, corner: vec2<i32>, admit: u32) -> LeafHit {
    steps += 1u;
    let first = corner - walk.tile.origin;
    // Cells are told apart first and met then, so that rays side by side meet their cells at the same time.
    let columns = vec4<f32>(first.x + vec4<i32>(0, 1, 2, 3));
    let near_x = times_of(0u, larger_four(columns, vec4<f32>(walk.tile.lo.x)));
    let next = vec4<f32>(first.x + vec4<i32>(1, 2, 3, 4));
    let far_x = times_of(0u, smaller_four(next, vec4<f32>(walk.tile.hi.x)));
    var cells = 0u;
    for (var y = 0; y < 4; y++) {
        let t0 = larger_four(vec4<f32>(row_enter(walk, first.y + y)), near_x);
        let t1 = smaller_four(vec4<f32>(row_leave(walk, first.y + y)), far_x);
        let crossed = (t0 < t1) & (vec4<f32>(ray.cull.x) <= t1) & (t0 <= vec4<f32>(ray.cull.y));
        cells |= bits_of_four(crossed) << u32(4 * y);
    }
    while cells != 0u {
        let lane = i32(firstTrailingBit(cells));
        cells &= cells - 1u;
        let fx = first.x + (lane & 3);
        let fy = first.y + (lane >> 2u);
        let near = larger(f32(fx), walk.tile.lo.x);
        let far = smaller(f32(fx + 1), walk.tile.hi.x);
        let t0 = larger(row_enter(walk, fy), time_of(0u, near));
        let t1 = smaller(row_leave(walk, fy), time_of(0u, far));
        let cell = vec2<i32>(fx, fy);
        let enters = vec2<f32>(entering(0u, fx, t0), entering(1u, fy, t0));
        let leaves = vec2<f32>(leaving(0u, fx, t1), leaving(1u, fy, t1));
        let gap = gap_of(enters, leaves, t0, t1, tile_corners(walk.tile, cell));
        var hit = first_root(gap, admit);
        if hit.found {
            hit.s = smaller(rounded(hit.s * rounded(t1 - t0)) + t0, t1);
            hit.cell = cell;
            if confirms(t0, hit, admit) {
                return hit;
            }
        }
    }
    return no_hit();
}

// Mirrored cell of the ray's end in a tile, or beyond it, on the map.
fn last_cell(walk: Walk, axis: u32) -> i32 {
    let end = i32(ray.o[axis] + walk.leave * ray.d[axis]) + 1;
    return on_map(walk, axis, walk.tile.origin[axis] + end);
}

fn on_map(walk: Walk, axis: u32, cell: i32) -> i32 {
    let cells = i32(shown_map.cells[axis]);
    let first = walk.tile.turn[axis] & -cells;
    return clamp(cell, first, first + cells - 1);
}

// Corner of the block at a lane of the node of a level that holds a cell.
fn child(cell: vec2<i32>, level: u32, lane: u32) -> vec2<i32> {
    let side = 2u * level + 2u;
    let node = vec2<i32>(-1) << vec2<u32>(side + 2u);
    return (cell & node) + vec2<i32>(i32((lane & 3u) << side), i32((lane >> 2u) << side));
}

// The lanes after the one that holds a cell in its node of a level.
fn lanes_after(cell: vec2<i32>, level: u32) -> u32 {
    let at = vec2<u32>(cell >> vec2<u32>(2u * level + 2u)) & vec2<u32>(3u);
    return ~1u << (4u * at.y + at.x);
}

// The first admitted crossing in a tile.
fn walk_pyramid(tile: Tile, admit: u32) -> LeafHit {
    var walk: Walk;
    walk.tile = tile;
    walk.enter = larger(tile.enter, ray.cull.x);
    walk.leave = smaller(tile.leave, ray.cull.y);
    walk.low_start = next_down(ray.oz - rounded(2.0 * slack()));
    walk.high_start = next_up(ray.oz + rounded(2.0 * slack()));
    walk.both = !ray.above;
    let top = shown_map.levels - 1u;
    var next = top;
    var last = top;
    var home = tile.turn;
    let climbs = walk.enter <= 0.0;
    if climbs {
        home = vec2<i32>(on_map(walk, 0u, tile.origin.x), on_map(walk, 1u, tile.origin.y));
        let end = vec2<i32>(last_cell(walk, 0u), last_cell(walk, 1u));
        // Level l holds both if they agree above its 4 + 2 l low bits.
        let bits = 32u - countLeadingZeros(u32((home.x ^ end.x) | (home.y ^ end.y)));
        last = min((max(bits, 3u) - 3u) / 2u, top);
        next = 0u;
        if walk.both {
            walk.both = gap_at(double(0.0)).x < 4.0 * slack();
        }
    }
    // What is left to visit, sixteen bits a level.
    var stack: array<u32, LEVELS>;
    var level = 0u;
    var lanes = 0u;
    var at = home;
    // The level of the node that was tested last without a parent.
    var root_level = 0u;
    loop {
        if lanes != 0u {
            let lane = firstTrailingBit(lanes);
            lanes &= lanes - 1u;
            at = child(at, level, lane);
            if level > 0u {
                stack[level] = lanes;
                level -= 1u;
                lanes = met(walk, level, at);
                continue;
            }
            let hit = first_in_block(walk, at, admit);
            if hit.found {
                return hit;
            }
        } else if level < root_level {
            level += 1u;
            lanes = stack[level];
        } else if next <= last {
            at = home;
            level = next;
            root_level = next;
            lanes = met(walk, level, at);
            if next > 0u && climbs {
                lanes &= lanes_after(home, next);
            }
            next += 1u;
        } else {
            break;
        }
    }
    return no_hit();
}

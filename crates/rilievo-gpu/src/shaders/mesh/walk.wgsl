// The twin of `relief/mesh/walk`: which cells under a prism are shown to the leaf, in order along the ray.
//
// As on the CPU, but for two things: the children of a node are tested one at a time, when it is their turn,
// so that nothing waits but the next of each level; and all of it is floats (see `frame`).

// Errors above this share of a child call for a new frame, which has to have less than that share of the old
// one's error, and be about a region that is smaller by as much.
const LARGE: f32 = 0.4;
const WORTH: f32 = 0.7;

// Levels of nodes that may have a frame of their own.
const FRAMES: u32 = 4u;

// The unfolded cells of one tile, counted along a ray: `sign unfolded + shift`. A stored cell is a forward cell
// combined with `turn`.
struct Forward {
    sign: vec2<f32>,
    shift: vec2<i32>,
    turn: vec2<i32>,
    // Forward cells of the tile that the prism shows.
    first: vec2<i32>,
    end: vec2<i32>,
    // From which paths count.
    base: vec2<i32>,
}

fn forward_of(runs: array<Run, 2>, speed: vec3<f32>) -> Forward {
    var all: Forward;
    for (var k = 0u; k < 2u; k++) {
        let run = runs[k];
        let first = max(prism.first[k], run.start);
        let end = min(prism.end[k], run.start + run.len);
        let backward = speed[k] < 0.0;
        let flipped = run.flipped != 0;
        // Where unfolded 0 is stored, counted in the direction of the run.
        let at = select(run.first - run.start, -(run.first + 1 + run.start), flipped);
        all.turn[k] = select(0, -1, flipped != backward);
        all.sign[k] = select(1.0, -1.0, backward);
        all.shift[k] = select(at, -at, backward);
        all.first[k] = select(first + at, -at - end, backward);
        all.end[k] = select(end + at, -at - first, backward);
        all.base[k] = select(prism.base[k], -prism.base[k], backward) + all.shift[k];
    }
    return all;
}

fn turned(path: Path, sign: vec2<f32>) -> Path {
    let turn = vec3<f32>(sign, 1.0);
    return Path(turn * path.start, turn * path.speed, turn * path.inverse, path.error);
}

// A frame about a square of cells between two heights, and how large its region is.
struct Framed {
    path: Path,
    size: f32,
}

// A better frame about cells from `corner` on, or the old one.
fn better_frame(forward: Forward, own: Path, old: Framed, square: vec3<i32>, heights: vec2<f32>) -> Framed {
    let first = vec2<f32>(max(square.xy, forward.first) - forward.base);
    let end = vec2<f32>(min(square.xy + square.z, forward.end) - forward.base);
    let a = forward.sign * prism.corners[0];
    let b = forward.sign * prism.corners[1];
    let c = forward.sign * prism.corners[2];
    let low = max(first, min(a, min(b, c))) - MARGIN;
    let high = min(end, max(a, max(b, c))) + MARGIN;
    let slack = relief_mesh.height_slack;
    let extent = vec3<f32>(high - low, heights.y - heights.x + 2.0 * slack);
    let size = max(extent.x, extent.y) * extent.z;
    if any(low > high) || size > WORTH * old.size {
        return old;
    }
    let centre = vec3<f32>(forward.sign, 1.0) * prism.centre;
    let path = path_about(
        own,
        forward.sign,
        centre,
        vec3<f32>(low, heights.x - slack),
        vec3<f32>(high, heights.y + slack),
    );
    let error = max(path.error.x, path.error.y);
    if error < WORTH * max(old.path.error.x, old.path.error.y) && error < f32(8 * square.z) {
        return Framed(path, size);
    }
    return old;
}

fn is_coarse(path: Path, part: f32) -> bool {
    return max(path.error.x, path.error.y) > LARGE * part;
}

// Heights over the level of a child of a node of a level, forward.
fn child_heights(level: u32, node: vec2<i32>, turn: vec2<i32>, child: vec2<u32>) -> vec2<f32> {
    let at = vec2<u32>(node ^ turn);
    let table = shown_map.bounds + 3u * level;
    let index = (at.y * bound_word(table) + at.x) * 8u;
    let stored = child ^ (vec2<u32>(turn) & vec2<u32>(3u));
    let word = index + stored.y * 2u + (stored.x >> 1u);
    let shift = 16u * (stored.x & 1u);
    let codes = vec2<u32>(bound_word(bound_word(table + 2u) + word), bound_word(bound_word(table + 1u) + word));
    let steps_up = vec2<f32>((codes >> vec2<u32>(shift)) & vec2<u32>(0xffffu));
    return shown_map.code_base + steps_up * shown_map.code_step - relief_mesh.level;
}

// Corners of a forward cell over the level.
fn cell_heights(cell: vec2<i32>, turn: vec2<i32>) -> vec4<f32> {
    return corners_of(cell ^ turn, turn) - relief_mesh.level;
}

fn range_of(h: vec4<f32>) -> vec2<f32> {
    return vec2<f32>(min(min(h.x, h.y), min(h.z, h.w)), max(max(h.x, h.y), max(h.z, h.w)));
}

// Whether a path may touch, over a span, the surface of a cell with its corner at a place: the gap is a
// quadratic and lies between its Bernstein coefficients.
fn touches(path: Path, span: vec2<f32>, corner: vec2<f32>, h: vec4<f32>) -> bool {
    let a = path_at(path, span.x) - vec3<f32>(corner, 0.0);
    let b = path_at(path, span.y) - vec3<f32>(corner, 0.0);
    let low = h.y - h.x;
    let high = h.w - h.z;
    let x = vec4<f32>(a.x, b.x, a.x, b.x);
    let y = vec4<f32>(a.y, a.y, b.y, b.y);
    let bottom = h.x + low * x;
    let surface = bottom + (h.z + high * x - bottom) * y;
    let b0 = a.z - surface.x;
    let b1 = 0.5 * (a.z + b.z - (surface.y + surface.z));
    let b2 = b.z - surface.w;
    let error = path.error + vec3<f32>(MARGIN, MARGIN, relief_mesh.height_slack);
    let twist = abs(high - low);
    let steep_x = max(abs(low), abs(high)) + twist * error.y;
    let steep_y = max(abs(h.z - h.x), abs(h.w - h.y)) + twist * error.x;
    // Rounding of the coefficients: heights grow outside of their cell.
    let grown = relief_mesh.half_range * (1.0 + 2.0 * error.x) * (1.0 + 2.0 * error.y);
    let rounding = (grown + error.z) * 1.9073486e-6;
    let m = steep_x * error.x + steep_y * error.y + error.z + rounding;
    return min(b0, min(b1, b2)) <= m && max(b0, max(b1, b2)) >= -m;
}

// Shows the cells of a block that the ray may meet to the leaf.
fn walk_block(forward: Forward, own: Path, old: Framed, span: vec2<f32>, block: vec2<i32>, index: u32) {
    steps += 1u;
    let corner = 4 * block;
    var framed = old;
    if is_coarse(framed.path, 1.0) {
        // Its own heights bound it better than its parent's.
        var range = vec2<f32>(MOST, -MOST);
        // Nine cells hold all samples of the block.
        for (var k = 0; k < 9; k++) {
            let cell = corner + min(2 * vec2<i32>(k % 3, k / 3), vec2<i32>(3));
            let own_range = range_of(cell_heights(cell, forward.turn));
            range = vec2<f32>(min(range.x, own_range.x), max(range.y, own_range.y));
        }
        let a = path_at(framed.path, span.x).z;
        let b = path_at(framed.path, span.y).z;
        let room = framed.path.error.z + relief_mesh.height_slack;
        if max(a, b) < range.x - room || min(a, b) > range.y + room {
            return;
        }
        framed = better_frame(forward, own, old, vec3<i32>(corner, 4), range);
    }
    let path = framed.path;
    // Cells are told apart first and shown then, so that rays side by side are in the leaf at the same time.
    var shown = 0u;
    for (var k = 0; k < 16; k++) {
        let cell = corner + vec2<i32>(k & 3, k >> 2u);
        if any(cell < forward.first) || any(cell >= forward.end) {
            continue;
        }
        let h = cell_heights(cell, forward.turn);
        let range = range_of(h);
        let at = vec2<f32>(cell - forward.base);
        let slack = relief_mesh.height_slack;
        let over = path_within(
            path,
            vec2<f32>(span.x, min(span.y, prism_limit())),
            vec3<f32>(at - MARGIN, range.x - slack),
            vec3<f32>(at + 1.0 + MARGIN, range.y + slack),
        );
        if over.x <= over.y && touches(path, over, at, h) {
            shown |= 1u << u32(k);
        }
    }
    let backward = forward.sign < vec2<f32>(0.0);
    while shown != 0u {
        let k = i32(firstTrailingBit(shown));
        shown &= shown - 1u;
        let cell = corner + vec2<i32>(k & 3, k >> 2u);
        leaf_of_mesh(select(cell - forward.shift, forward.shift - cell - 1, backward), index);
    }
}

// Walks one tile.
fn walk_mesh_tile(forward: Forward, own: Path, span: vec2<f32>, index: u32) {
    let a = path_at(own, span.x).xy;
    let b = path_at(own, span.y).xy;
    let room = own.error.xy + MARGIN;
    let wide = vec2<f32>(1e9);
    let lowest = vec2<i32>(floor(clamp(min(a, b) - room, -wide, wide)));
    let highest = vec2<i32>(floor(clamp(max(a, b) + room, -wide, wide)));
    let part_first = max(forward.first, lowest + forward.base);
    let part_last = min(forward.end, highest + 1 + forward.base) - 1;
    if any(part_first > part_last) {
        return;
    }
    // The smallest level of which 4 x 4 nodes, or blocks, hold the part.
    var top = -1;
    var bits = vec2<u32>(2u);
    while any((part_last >> bits) - (part_first >> bits) > vec2<i32>(3)) {
        top += 1;
        bits += 2u;
    }
    var firsts: array<vec2<i32>, LEVELS>;
    var spans: array<vec2<f32>, LEVELS>;
    var frames: array<u32, LEVELS>;
    var lanes: array<u32, LEVELS>;
    var made: array<Framed, 5>;
    let extent = max(prism.end.x - prism.first.x, prism.end.y - prism.first.y);
    made[0] = Framed(own, f32(extent) * (prism.high - prism.low));
    var depth = 0u;
    firsts[0] = part_first >> bits;
    spans[0] = span;
    frames[0] = 0u;
    lanes[0] = 0u;
    loop {
        let lane = lanes[depth];
        if lane >= 16u {
            if depth == 0u {
                break;
            }
            depth -= 1u;
            continue;
        }
        lanes[depth] = lane + 1u;
        let level = top - i32(depth);
        let child = vec2<u32>(lane & 3u, lane >> 2u);
        let place = firsts[depth] + vec2<i32>(child);
        let side = 4 << u32(2 * (level + 1));
        let corner = place * side;
        if any(corner >= forward.end) || any(corner + side <= forward.first) {
            continue;
        }
        var heights = vec2<f32>(prism.low, prism.high);
        if depth > 0u {
            heights = child_heights(u32(level + 1), firsts[depth] >> vec2<u32>(2u), forward.turn, child);
        }
        var frame = frames[depth];
        let at = vec2<f32>(corner - forward.base);
        let slack = relief_mesh.height_slack;
        let over = path_within(
            made[frame].path,
            vec2<f32>(spans[depth].x, min(spans[depth].y, prism_limit())),
            vec3<f32>(at - MARGIN, heights.x - slack),
            vec3<f32>(at + f32(side) + MARGIN, heights.y + slack),
        );
        if over.x > over.y {
            continue;
        }
        if level < 0 {
            walk_block(forward, own, made[frame], over, place, index);
            continue;
        }
        steps += 1u;
        if is_coarse(made[frame].path, 0.25 * f32(side)) && u32(level) < FRAMES {
            made[u32(level) + 1u] =
                better_frame(forward, own, made[frame], vec3<i32>(corner, side), heights);
            frame = u32(level) + 1u;
        }
        depth += 1u;
        firsts[depth] = 4 * place;
        spans[depth] = over;
        frames[depth] = frame;
        lanes[depth] = 0u;
    }
}

// One ray through one prism.
fn walk_prism(index: u32) {
    let path = read_prism(index);
    if prism.span < 0.0 {
        return;
    }
    if prism.flags != (prism.flags | SPREAD | SEES) {
        // The uv span no area, or the triangle has no frame: every cell under it.
        for (var y = prism.first.y; y < prism.end.y; y++) {
            let row = footprint_row(f32(y - prism.base.y)) + prism.base.x;
            for (var x = max(row.x, prism.first.x); x < min(row.y, prism.end.x); x++) {
                let cell = vec2<i32>(x, y);
                if !misses_footprint(vec2<f32>(cell - prism.base)) {
                    leaf_of_mesh(cell, index);
                }
            }
        }
        return;
    }
    let span = clip_prism(path);
    if span.x > span.y {
        return;
    }
    let a = path_at(path, span.x).xy;
    let b = path_at(path, span.y).xy;
    let room = path.error.xy + MARGIN;
    let wide = vec2<f32>(1e9);
    let lowest = vec2<i32>(floor(clamp(min(a, b) - room, -wide, wide))) + prism.base;
    let highest = vec2<i32>(floor(clamp(max(a, b) + room, -wide, wide))) + prism.base;
    let first = max(prism.first, lowest);
    let end = min(prism.end, highest + 1);
    var next = first.x;
    var runs: array<Run, 2>;
    while next < end.x {
        runs[0] = run_of(0u, next);
        next = runs[0].start + runs[0].len;
        var next_y = first.y;
        while next_y < end.y {
            runs[1] = run_of(1u, next_y);
            next_y = runs[1].start + runs[1].len;
            let starts = vec2<i32>(runs[0].start, runs[1].start);
            let ends = starts + vec2<i32>(runs[0].len, runs[1].len);
            let over = path_within(
                path,
                span,
                vec3<f32>(vec2<f32>(starts - prism.base) - MARGIN, -MOST),
                vec3<f32>(vec2<f32>(ends - prism.base) + MARGIN, MOST),
            );
            if over.x <= over.y {
                let forward = forward_of(runs, path.speed);
                walk_mesh_tile(forward, turned(path, forward.sign), over, index);
            }
        }
    }
}

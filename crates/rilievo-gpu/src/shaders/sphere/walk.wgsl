// The twin of `relief/sphere/walk.rs`: the cells of a segment in order, by the pyramid of its face of the cube.

fn on_cube(cell: vec2<i32>) -> bool {
    return all(cell >= vec2<i32>(0)) && all(cell < vec2<i32>(i32(radii.cells)));
}

// The first crossing under the segment at hand, and its cell in `sphere_cell`.
var<private> sphere_cell: vec2<u32>;

fn walk_segment() -> GapRoot {
    // The smallest node that holds all cells under the segment, mirrored.
    var node: vec2<i32>;
    var differing = 0;
    for (var k = 0u; k < 2u; k++) {
        let from_ = segment.origin[k].x;
        let to = from_ + segment.slope[k].x;
        // Floats of cells' coordinates are off by less.
        let beside = 2.5e-7 * f32(radii.cells);
        let low = i32(max(min(from_, to) - beside, 0.0));
        let high = min(i32(max(from_, to) + beside), i32(radii.cells) - 1);
        node[k] = low ^ sweep.turn[k];
        differing |= low ^ high;
    }
    let bits = 32u - countLeadingZeros(u32(differing));
    let top = (max(bits, 3u) - 3u) / 2u;
    node = node >> vec2<u32>(4u + 2u * top);
    var stack: array<u32, LEVELS>;
    var level = top;
    var lanes = 0u;
    var enters = true;
    var none: GapRoot;
    none.found = false;
    loop {
        if enters {
            steps += 1u;
            lanes = sweep_node(level, node);
            enters = false;
        }
        if lanes == 0u {
            if level == top {
                return none;
            }
            level += 1u;
            lanes = stack[level];
            node = node >> vec2<u32>(2u);
            continue;
        }
        let lane = firstTrailingBit(lanes);
        lanes &= lanes - 1u;
        let child = 4 * node + vec2<i32>(vec2<u32>(lane & 3u, lane >> 2u));
        let corner = child << vec2<u32>(2u * level + 2u);
        // Widened intervals may lead beyond the map.
        if !on_cube((child ^ sweep.turn) << vec2<u32>(2u * level + 2u)) {
            continue;
        }
        if level > 0u {
            stack[level] = lanes;
            level -= 1u;
            node = child;
            enters = true;
            continue;
        }
        steps += 1u;
        for (var k = 0; k < 16; k++) {
            let mirrored = corner + vec2<i32>(k & 3, k >> 2u);
            let cell = mirrored ^ sweep.turn;
            if !on_cube(cell) || !sweep_cell(mirrored) {
                continue;
            }
            let met = segment_meet(vec2<u32>(cell));
            if met.found {
                sphere_cell = vec2<u32>(cell);
                return met;
            }
        }
    }
    return none;
}

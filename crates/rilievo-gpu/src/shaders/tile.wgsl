// The twin of `relief/tile.rs` and `relief/walk/frame.rs`: the part of a face over which unfolded
// cells show stored cells by a shift or a flip, in mirrored cells, as the descent counts them.

struct Tile {
    // First forward cell and one past the last, inside the window.
    first: vec2<i32>,
    end: vec2<i32>,
    // Mirrored cell of forward cell 0.
    origin: vec2<i32>,
    // What stored cells are combined with to give mirrored cells: 0, or -1 where they fall.
    turn: vec2<i32>,
    // Near and far lines inside the window.
    lo: vec2<f32>,
    hi: vec2<f32>,
    // Parameters at which the ray enters and leaves, not before 0 nor after 1.
    enter: f32,
    leave: f32,
}

// The tile that holds a forward cell.
fn tile_of(cell: vec2<i32>) -> Tile {
    var t: Tile;
    t.enter = 0.0;
    t.leave = 1.0;
    for (var k = 0u; k < 2u; k++) {
        let i = unfolded(k, cell[k]);
        let run = run_of(k, i);
        let backward = ray.turn[k] != 0;
        let base = ray.base[k];
        let run_end = run.start + run.len;
        t.first[k] = max(select(run.start - base, base - run_end, backward), first_cell(k));
        t.end[k] = min(select(run_end - base, base - run.start, backward), end_cell(k));
        t.turn[k] = ray.turn[k] ^ run.flipped;
        let shown = stored(run, i);
        let offset = select(shown - cell[k], shown + cell[k], t.turn[k] != 0);
        t.origin[k] = offset ^ t.turn[k];
        t.lo[k] = larger(f32(t.first[k]), ray.lo[k]);
        t.hi[k] = smaller(f32(t.end[k]), ray.hi[k]);
        t.enter = larger(t.enter, time_of(k, t.lo[k]));
        t.leave = smaller(t.leave, time_of(k, t.hi[k]));
    }
    return t;
}

// Corners of a forward cell of a tile, in forward order.
fn tile_corners(t: Tile, cell: vec2<i32>) -> vec4<f32> {
    return corners_of((t.origin + cell) ^ t.turn, t.turn);
}

// Whether the ray leaves a tile across the far line of an axis.
fn leaves_across(t: Tile, axis: u32) -> bool {
    return time_of(axis, t.hi[axis]) <= t.leave;
}

// Gap above the surface where the ray enters a tile, as the leaf of the first cell computes it.
fn gap_at_enter(t: Tile) -> f32 {
    let x = clamp(cell_at(0u, t.enter), t.first.x, t.end.x - 1);
    let y = clamp(cell_at(1u, t.enter), t.first.y, t.end.y - 1);
    let h = tile_corners(t, vec2<i32>(x, y));
    let under = bilinear(h, entering(0u, x, t.enter), entering(1u, y, t.enter));
    return rounded(height_at(t.enter)) - rounded(under);
}

// Gap above the surface where the ray leaves a tile, as the leaf of the last cell computes it.
fn gap_at_leave(t: Tile) -> f32 {
    let x = clamp(cell_before(0u, t.leave), t.first.x, t.end.x - 1);
    let y = clamp(cell_before(1u, t.leave), t.first.y, t.end.y - 1);
    let h = tile_corners(t, vec2<i32>(x, y));
    let under = bilinear(h, leaving(0u, x, t.leave), leaving(1u, y, t.leave));
    return rounded(height_at(t.leave)) - rounded(under);
}

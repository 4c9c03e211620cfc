// The twin of `relief/walls.rs`: upright walls around a closed face, and between tiles whose heights
// differ. They are met where the leaf's own gaps before and behind a line have different signs.

// What an exact walk meets.
struct Met {
    hit: LeafHit,
    // 0, or the kind of wall as in a ray.
    wall: u32,
    line: i32,
}

fn wall_between(wall: u32, s: f32, before: f32, behind: f32) -> Met {
    // The rim itself belongs to the wall.
    let from_above = before > 0.0;
    let crosses = from_above != (behind > 0.0) && admits(admitted(), from_above);
    return Met(LeafHit(crosses, s, vec2<i32>(0), from_above), wall, 0);
}

// Gap above offset 0, which the border's walls go down to.
fn gap_to_base(s: f32) -> f32 {
    return rounded(height_at(s)) - shown_map.raw_zero;
}

fn border(axis: u32, low: bool) -> u32 {
    return 1u + 2u * axis + select(1u, 0u, low);
}

// The border's wall where the ray enters the window.
fn entry_wall(s: f32) -> Met {
    let behind = gap_at_enter(tile_of(vec2<i32>(cell_at(0u, s), cell_at(1u, s))));
    let axis = select(0u, 1u, time_of(0u, ray.lo.x) < time_of(1u, ray.lo.y));
    return wall_between(border(axis, ray.turn[axis] == 0), s, gap_to_base(s), behind);
}

// The border's wall where the ray leaves the window.
fn exit_wall(s: f32) -> Met {
    let before = gap_at_leave(tile_of(vec2<i32>(cell_before(0u, s), cell_before(1u, s))));
    let axis = select(0u, 1u, time_of(0u, ray.hi.x) > time_of(1u, ray.hi.y));
    return wall_between(border(axis, ray.turn[axis] != 0), s, before, gap_to_base(s));
}

// The wall between a tile and the one that begins at a cell, across the axis crossed first.
fn seam_wall(tile: Tile, cell: vec2<i32>, axis: u32) -> Met {
    let before = gap_at_leave(tile);
    let behind = gap_at_enter(tile_of(cell));
    var met = wall_between(5u + axis, tile.leave, before, behind);
    met.line = unfolded_line(axis, cell[axis]);
    return met;
}

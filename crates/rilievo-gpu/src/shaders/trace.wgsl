// The twin of `relief/trace.rs`: from tile to tile of the unfolded map, and the crossing of what is
// met, in doubles.

fn nothing_met() -> Met {
    return Met(no_hit(), 0u, 0);
}

// Whether the surface may jump where two tiles meet.
fn has_seams() -> bool {
    return shown_map.texel == 0u && shown_map.wrap == REPEAT;
}

// Walks the tiles front to back.
fn first_met() -> Met {
    let near = larger(time_of(0u, ray.lo.x), time_of(1u, ray.lo.y));
    let far = smaller(time_of(0u, ray.hi.x), time_of(1u, ray.hi.y));
    let enter = larger(near, 0.0);
    let leave = smaller(far, 1.0);
    if enter >= leave {
        return nothing_met();
    }
    if has(CLOSED) && enter > 0.0 {
        let wall = entry_wall(enter);
        if wall.hit.found {
            return wall;
        }
    }
    let start = larger(enter, ray.cull.x);
    let stop = smaller(leave, ray.cull.y);
    if start < stop {
        let met = walk_tiles(start, stop);
        if met.hit.found {
            return met;
        }
    }
    if has(CLOSED) && leave < 1.0 {
        return exit_wall(leave);
    }
    return nothing_met();
}

fn walk_tiles(start: f32, stop: f32) -> Met {
    var cell = vec2<i32>(cell_at(0u, start), cell_at(1u, start));
    loop {
        let tile = tile_of(cell);
        let hit = walk_tile(tile, start, stop);
        if hit.found {
            return Met(hit, 0u, 0);
        }
        if tile.leave >= stop {
            break;
        }
        let crossed_x = leaves_across(tile, 0u);
        for (var k = 0u; k < 2u; k++) {
            if leaves_across(tile, k) {
                cell[k] = tile.end[k];
            } else {
                cell[k] = clamp(cell_at(k, tile.leave), tile.first[k], tile.end[k] - 1);
            }
        }
        if cell.x >= end_cell(0u) || cell.y >= end_cell(1u) {
            break;
        }
        if has_seams() {
            let wall = seam_wall(tile, cell, select(1u, 0u, crossed_x));
            if wall.hit.found {
                return wall;
            }
        }
    }
    return nothing_met();
}

// The line of a wall in lattice space.
fn wall_line(met: Met) -> Double {
    if met.wall > 4u {
        return double(f32(met.line));
    }
    let axis = (met.wall - 1u) / 2u;
    if ((met.wall - 1u) & 1u) == 1u {
        return faces[face].window_high[axis];
    }
    return faces[face].window_low[axis];
}

// The nearest crossing of the face at hand, which is surface `number`, up to the ray's end.
fn meet_face(source: Ray, t_max: Double, number: u32) -> Hit {
    var hit: Hit;
    hit.surface = NOTHING;
    if !prepare(source, t_max, number) {
        return hit;
    }
    if meets_points() {
        return meet_points(t_max, number);
    }
    let met = first_met();
    if !met.hit.found {
        return hit;
    }
    var s: Double;
    if met.wall == 0u {
        let cell = vec2<i32>(unfolded(0u, met.hit.cell.x), unfolded(1u, met.hit.cell.y));
        let root = root_across(cell, met.hit.s);
        s = root.s;
        hit.cell = root.cell;
        hit.local = root.local;
    } else {
        let axis = select((met.wall - 1u) / 2u, met.wall - 5u, met.wall > 4u);
        let towards = difference(wall_line(met), exact.origin[axis]);
        s = double(met.hit.s);
        if !is_zero(exact.direction[axis]) {
            s = larger_double(ratio(towards, exact.direction[axis]), double(0.0));
        }
        hit.cell = vec2<i32>(met.line, 0);
    }
    hit.t = sum(exact.t_start, product(s, exact.t_length));
    if below(t_max, hit.t) {
        return hit;
    }
    hit.surface = number;
    hit.part = met.wall << WALL_SHIFT;
    if met.hit.from_above == has(RISES) {
        hit.part |= FRONT;
    }
    return hit;
}

// The twin of `relief/sphere/mod.rs`: one ray against one displaced sphere, part by part and face by face of
// the cube around it.

// The nearest crossing with the sphere at a place of `numbers`, within [0, t_max].
fn meet_relief_sphere(source: Ray, t_max: Double, place: u32, leaves: bool) -> Hit {
    var hit: Hit;
    hit.surface = NOTHING;
    read_radii(place);
    let towards_front = (source.leaves & FRONT) != 0u;
    let lift = select(0.0, select(-radii.lift, radii.lift, towards_front), leaves);
    var origin: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        let arm = difference(source.origin[k], number_at(place + 2u * k));
        origin[k] = sum(arm, scaled(arm, lift));
    }
    let chords = chords_of(origin, source.direction);
    for (var k = 0u; k < 2u; k++) {
        let part = sphere_part(chords, k == 1u);
        if part.length.x < 0.0 {
            continue;
        }
        if below(t_max, part.t) {
            return hit;
        }
        let home = face_towards(part.start);
        var here = over_face(home, part.start, sign_of(home) * part.start[home / 2u], NOTHING);
        segment.gaps[1] = gap_over(here);
        segment.t[1] = double(0.0);
        var outside = part.begins == ROOF;
        if part.begins == ORIGIN {
            // The lift has put it there.
            outside = select(segment.gaps[1].x > 0.0, towards_front, leaves);
        }
        // Each face of the cube comes once.
        for (var count = 0u; count < 6u; count++) {
            segment.gaps[0] = segment.gaps[1];
            segment.t[0] = segment.t[1];
            if below(t_max, sum(part.t, segment.t[0])) {
                return hit;
            }
            let next = leave_face(part, here.face);
            let t = segment.t[1];
            var point: array<Double, 3>;
            for (var m = 0u; m < 3u; m++) {
                point[m] = sum(part.start[m], product(t, part.direction[m]));
            }
            var z = sign_of(here.face) * point[here.face / 2u];
            if next != NOTHING {
                z = scaled(sum(z, sign_of(next) * point[next / 2u]), 0.5);
            }
            let there = over_face(here.face, point, z, next);
            segment.gaps[1] = gap_over(there);
            make_segment(here, there);
            let rest = difference(t_max, part.t);
            make_sweep(outside, segment_s(part.nearest), segment_s(rest));
            let met = walk_segment();
            if met.found {
                let at = sum(part.t, segment_t(met.at));
                if below(t_max, at) {
                    return hit;
                }
                hit.t = at;
                for (var m = 0u; m < 2u; m++) {
                    hit.local[m] = segment_local(m, sphere_cell[m], met.at);
                }
                hit.cell = vec2<i32>(sphere_cell);
                hit.part = (segment.face << WALL_SHIFT) | select(0u, FRONT, met.outside);
                hit.surface = 0u;
                return hit;
            }
            if next == NOTHING {
                break;
            }
            here = over_face(next, point, z, here.face);
        }
    }
    return hit;
}

// Where a part of a ray leaves a face of the cube before it ends, which becomes the segment's end, and for
// which, or NOTHING.
fn leave_face(part: SpherePart, cube_face: u32) -> u32 {
    let axis = cube_face / 2u;
    let along = sign_of(cube_face) * part.start[axis];
    let speed = sign_of(cube_face) * part.direction[axis];
    var next = NOTHING;
    segment.t[1] = part.length;
    for (var k = 0u; k < 4u; k++) {
        let other = 2u * across(cube_face, k >> 1u) + (k & 1u);
        let gain = difference(sign_of(other) * part.direction[other / 2u], speed);
        if gain.x > 0.0 {
            let short = difference(along, sign_of(other) * part.start[other / 2u]);
            let t = larger_double(ratio(short, gain), segment.t[0]);
            if below(t, segment.t[1]) {
                segment.t[1] = t;
                next = other;
            }
        }
    }
    return next;
}

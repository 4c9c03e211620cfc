// The twin of method `published` of `relief/approximate.rs`, in floats (see `approximate`): the paper as it was, with steps
// by interpolated distances.

// See `PUBLISHED_STEPS` and `PUBLISHED_EPSILON` of the CPU.
const PUBLISHED_STEPS: u32 = 256u;
const PUBLISHED_EPSILON: f32 = 0.0009765625;

// The prepared ray in unfolded cells and raw height.
struct Segment {
    origin: vec3<f32>,
    direction: vec3<f32>,
    begin: f32,
    end: f32,
}

fn segment_of() -> Segment {
    var at: Segment;
    at.begin = 0.0;
    at.end = ray.cull.y;
    for (var k = 0u; k < 3u; k++) {
        let o = exact.origin[k];
        at.origin[k] = o.x;
        at.direction[k] = exact.direction[k].x;
        var low = double(shown_map.low);
        var high = double(shown_map.high);
        if k < 2u {
            low = faces[face].window_low[k];
            high = faces[face].window_high[k];
        }
        if at.direction[k] == 0.0 {
            if below(o, low) || below(high, o) {
                at.end = -1.0;
            }
            continue;
        }
        let a = difference(low, o).x / at.direction[k];
        let b = difference(high, o).x / at.direction[k];
        at.begin = larger(at.begin, smaller(a, b));
        at.end = smaller(at.end, larger(a, b));
    }
    return at;
}

// Stored-cell coordinate of an unfolded one.
fn stored_coordinate(axis: u32, x: f32) -> f32 {
    let run = run_of(axis, i32(floor(x)));
    let along = x - f32(run.start);
    return select(f32(run.first) + along, f32(run.first) + 1.0 - along, run.flipped != 0);
}

fn gap_at_point(p: vec3<f32>) -> f32 {
    let cell = vec2<f32>(cell_in_window(0u, floor(p.x)), cell_in_window(1u, floor(p.y)));
    let local = p.xy - cell;
    let h = unfolded_corners(vec2<i32>(cell));
    return p.z - mix(mix(h.x, h.y, local.x), mix(h.z, h.w, local.x), local.y);
}

// Where the paper believes that the face is met.
fn march_published() -> LeafHit {
    load_distance_map();
    var hit = no_hit();
    let segment = segment_of();
    let top = vec3<f32>(distance_map.size - vec3<u32>(1u));
    let last = vec3<u32>(distance_map.size - vec3<u32>(2u));
    let per_distance = 1.0 / length(distance_map.metric * segment.direction);
    let epsilon = PUBLISHED_EPSILON * (shown_map.high - shown_map.low);
    var s = segment.begin;
    if spawned {
        let speed = max(abs(segment.direction.x), abs(segment.direction.y));
        s += select(segment.end - segment.begin, 0.5 / speed, speed > 0.0);
    }
    for (var k = 0u; k < PUBLISHED_STEPS; k++) {
        if !(s <= segment.end) {
            break;
        }
        steps += 1u;
        let p = segment.origin + s * segment.direction;
        let gap = gap_at_point(p);
        let above = gap >= 0.0;
        if k == 0u {
            hit.from_above = above;
        }
        if abs(gap) <= epsilon || hit.from_above != above {
            hit.s = s;
            hit.found = admits(admitted(), hit.from_above);
            break;
        }
        var place = vec3<f32>(stored_coordinate(0u, p.x), stored_coordinate(1u, p.y), p.z - shown_map.low);
        place = clamp(place * distance_map.density, vec3<f32>(0.0), top);
        s += distance_in(min(vec3<u32>(place), last), place) * per_distance;
    }
    return hit;
}

// What the paper meets, as a hit of the face at hand, up to the ray's end.
fn meet_published(t_max: Double, number: u32) -> Hit {
    let met = march_published();
    return hit_at_point(PointHit(met.found, double(met.s), met.from_above), t_max, number);
}

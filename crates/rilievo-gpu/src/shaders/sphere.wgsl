// The twin of `surface/sphere.rs` in doubles.

fn dot_double(a: array<Double, 3>, b: array<Double, 3>) -> Double {
    return sum(sum(product(a[0], b[0]), product(a[1], b[1])), product(a[2], b[2]));
}

// The nearest meeting of the sphere at a place of `numbers` within [0, t_max].
fn meet_sphere(source: Ray, t_max: Double, place: u32, leaves: bool) -> Hit {
    var hit: Hit;
    hit.surface = NOTHING;
    var f: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        f[k] = difference(source.origin[k], number_at(place + 2u * k));
    }
    let radius = number_at(place + 6u);
    let d = source.direction;
    let a = dot_double(d, d);
    let b = -dot_double(f, d);
    let middle = ratio(b, a);
    if leaves {
        hit.t = scaled(middle, 2.0);
        if (source.leaves & FRONT) == 0u && hit.t.x > 0.0 && at_most(hit.t, t_max) {
            hit.surface = 0u;
        }
        return hit;
    }
    var nearest: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        nearest[k] = sum(f[k], product(middle, d[k]));
    }
    let half_chord = difference(product(radius, radius), dot_double(nearest, nearest));
    if half_chord.x < 0.0 {
        return hit;
    }
    let distance = root(dot_double(f, f));
    let c = product(difference(distance, radius), sum(distance, radius));
    let r = product(root(a), root(half_chord));
    var first = ratio(difference(b, r), a);
    var second = ratio(c, difference(b, r));
    if b.x >= 0.0 {
        first = ratio(c, sum(b, r));
        second = ratio(sum(b, r), a);
    }
    if first.x >= 0.0 && at_most(first, t_max) {
        hit.t = first;
        hit.part = FRONT;
        hit.surface = 0u;
    } else if second.x >= 0.0 && at_most(second, t_max) {
        hit.t = second;
        hit.surface = 0u;
    }
    return hit;
}

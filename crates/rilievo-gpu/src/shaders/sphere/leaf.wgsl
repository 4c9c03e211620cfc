// The twin of `relief/sphere/leaf.rs` in doubles.

fn lerp_double(a: Double, b: Double, t: Double) -> Double {
    return sum(product(t, b), difference(a, product(t, a)));
}

fn bilinear_double(h: array<Double, 4>, x: Double, y: Double) -> Double {
    return lerp_double(lerp_double(h[0], h[2], y), lerp_double(h[1], h[3], y), x);
}

struct GapRoot {
    found: bool,
    // As a fraction of the part.
    at: Double,
    outside: bool,
}

// The first root of a gap in Bernstein form, and whether it comes from outside.
fn first_root_double(b0: Double, b1: Double, b2: Double) -> GapRoot {
    // A ray that starts on the surface came from the side it does not go to.
    let outside = b0.x > 0.0 || (b0.x == 0.0 && (b1.x < 0.0 || (b1.x == 0.0 && b2.x < 0.0)));
    let sign = select(-1.0, 1.0, outside);
    let c0 = sign * b0;
    let c1 = sign * b1;
    let c2 = sign * b2;
    if c0.x == 0.0 {
        return GapRoot(true, double(0.0), outside);
    }
    let discriminant = difference(product(c1, c1), product(c0, c2));
    if c2.x > 0.0 && (c1.x >= 0.0 || discriminant.x < 0.0) {
        return GapRoot(false, double(0.0), outside);
    }
    let r = root(discriminant);
    var above = c0;
    var under = sum(difference(c0, c1), r);
    if c1.x > 0.0 {
        above = sum(c1, r);
        under = difference(above, c2);
    }
    return GapRoot(true, smaller_double(ratio(above, under), double(1.0)), outside);
}

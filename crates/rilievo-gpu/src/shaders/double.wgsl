// Double: the unevaluated sum of two floats, the first of them the sum rounded
// [Dekker1971]. About 48 bits, the exponents of f32. It stands in for the f64 of the CPU, which
// WGSL lacks, wherever a ray is prepared and a root refined.

alias Double = vec2<f32>;

fn double(x: f32) -> Double {
    return Double(x, 0.0);
}

// The sum and its error, for |a| >= |b|.
fn quick_two_sum(a: f32, b: f32) -> Double {
    let s = rounded(a + b);
    return Double(s, b - rounded(s - a));
}

fn two_sum(a: f32, b: f32) -> Double {
    let s = rounded(a + b);
    let c = rounded(s - a);
    return Double(s, (a - rounded(s - c)) + (b - c));
}

// Twelve bits of a float, to the nearest; what is left has as many.
fn leading(a: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(a) + 0x800u) & 0xfffff000u);
}

// The product and its error. All partial products are exact, so that fusing changes nothing.
fn two_product(a: f32, b: f32) -> Double {
    let p = rounded(a * b);
    let a1 = leading(a);
    let b1 = leading(b);
    let a2 = a - a1;
    let b2 = b - b1;
    let e = rounded(rounded(rounded(a1 * b1) - p) + rounded(a1 * b2)) + rounded(a2 * b1);
    return Double(p, rounded(e) + rounded(a2 * b2));
}

fn sum(a: Double, b: Double) -> Double {
    let s = two_sum(a.x, b.x);
    let t = two_sum(a.y, b.y);
    let u = quick_two_sum(s.x, rounded(s.y + t.x));
    return quick_two_sum(u.x, rounded(u.y + t.y));
}

fn difference(a: Double, b: Double) -> Double {
    return sum(a, -b);
}

fn product(a: Double, b: Double) -> Double {
    let p = two_product(a.x, b.x);
    return quick_two_sum(p.x, p.y + rounded(rounded(a.x * b.y) + rounded(a.y * b.x)));
}

// The product with a float.
fn scaled(a: Double, b: f32) -> Double {
    let p = two_product(a.x, b);
    return quick_two_sum(p.x, p.y + rounded(a.y * b));
}

fn ratio(a: Double, b: Double) -> Double {
    let q = rounded(a.x / b.x);
    let r = difference(a, scaled(b, q));
    let q2 = rounded(r.x / b.x);
    let r2 = difference(r, scaled(b, q2));
    let s = quick_two_sum(q, q2);
    return sum(s, double(rounded(r2.x / b.x)));
}

// Of a number that is not negative.
fn root(a: Double) -> Double {
    if a.x <= 0.0 {
        return double(0.0);
    }
    var s = double(rounded(sqrt(a.x)));
    for (var k = 0; k < 2; k++) {
        let error = difference(a, product(s, s));
        s = sum(s, double(rounded(error.x / rounded(2.0 * s.x))));
    }
    return s;
}

fn below(a: Double, b: Double) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

fn at_most(a: Double, b: Double) -> bool {
    return a.x < b.x || (a.x == b.x && a.y <= b.y);
}

fn larger_double(a: Double, b: Double) -> Double {
    return select(b, a, below(b, a));
}

fn smaller_double(a: Double, b: Double) -> Double {
    return select(b, a, below(a, b));
}

fn is_zero(a: Double) -> bool {
    return a.x == 0.0;
}

fn is_finite(a: Double) -> bool {
    return abs(a.x) < 3e38;
}

fn magnitude(a: Double) -> Double {
    return select(a, -a, a.x < 0.0);
}

// The largest whole number not above; for numbers below 2^24 in size.
fn floored(a: Double) -> f32 {
    let whole = floor(a.x);
    // The first float may be whole and the second negative.
    return select(whole, whole - 1.0, whole == a.x && a.y < 0.0);
}

// 1 / d, and a huge number instead of an infinite one, so that its product with 0 is 0.
fn reciprocal(d: Double) -> Double {
    if abs(d.x) > 1e-30 {
        return ratio(double(1.0), d);
    }
    return double(select(1e30, -1e30, d.x < 0.0));
}

// The twin of `surface/motion.rs`: a turn about an axis through a pivot that goes along a straight line, at the time of a
// ray. Sines and cosines are doubles, by their series: an angle is off by its last bit, as on the CPU.

struct Motion {
    // At time 0, relative to the anchor of the scene.
    pivot: array<Double, 3>,
    // Gone at time 1.
    translation: array<Double, 3>,
    // Unit.
    axis: array<Double, 3>,
    // Turned at time 1.
    turns: Double,
}

// What is left of a motion at a time: where the pivot is, and the turn.
struct Turn {
    pivot: array<Double, 3>,
    axis: array<Double, 3>,
    sine: Double,
    cosine: Double,
}

// A sum of powers of q, from the highest on.
fn with_power(so_far: Double, q: Double, next: Double) -> Double {
    return sum(next, product(so_far, q));
}

// Sine and cosine of a number of turns, at most 2^20.
fn sine_and_cosine(turns: Double) -> array<Double, 2> {
    let quarter = floored(sum(turns * 4.0, double(0.5)));
    let x = product(difference(turns * 4.0, double(quarter)), Double(1.57079637, -4.37113883e-8));
    let q = -product(x, x);
    var s = double(7.64716361e-13);
    s = with_power(s, q, double(1.60590444e-10));
    s = with_power(s, q, double(2.50521079e-8));
    s = with_power(s, q, Double(2.75573188e-6, 3.79357122e-14));
    s = with_power(s, q, Double(1.98412701e-4, -2.72559687e-12));
    s = with_power(s, q, Double(8.33333377e-3, -4.34617203e-10));
    s = with_power(s, q, Double(1.66666672e-1, -4.96705388e-9));
    s = product(with_power(s, q, double(1.0)), x);
    var c = double(4.77947726e-14);
    c = with_power(c, q, double(1.14707454e-11));
    c = with_power(c, q, double(2.08767559e-9));
    c = with_power(c, q, Double(2.755732e-7, -7.57511221e-15));
    c = with_power(c, q, Double(2.48015876e-5, -3.40699609e-13));
    c = with_power(c, q, Double(1.38888892e-3, -3.36310944e-11));
    c = with_power(c, q, Double(4.16666679e-2, -1.24176347e-9));
    c = with_power(c, q, double(0.5));
    c = with_power(c, q, double(1.0));
    switch i32(quarter) & 3 {
        case 0: { return array<Double, 2>(s, c); }
        case 1: { return array<Double, 2>(c, -s); }
        case 2: { return array<Double, 2>(-s, -c); }
        default: { return array<Double, 2>(-c, s); }
    }
}

// A motion at a time from 0 to 1.
fn turn_at(motion: Motion, time: Double) -> Turn {
    var turn: Turn;
    for (var k = 0u; k < 3u; k++) {
        turn.pivot[k] = sum(motion.pivot[k], product(time, motion.translation[k]));
    }
    turn.axis = motion.axis;
    let both = sine_and_cosine(product(time, motion.turns));
    turn.sine = both[0];
    turn.cosine = both[1];
    return turn;
}

// A vector turned back to time 0; with another sign of the sine, from there.
fn turned_about(turn: Turn, sine: Double, v: array<Double, 3>) -> array<Double, 3> {
    let a = turn.axis;
    let along = sum(sum(product(a[0], v[0]), product(a[1], v[1])), product(a[2], v[2]));
    let kept = product(along, difference(double(1.0), turn.cosine));
    var out: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        let m = (k + 1u) % 3u;
        let n = (k + 2u) % 3u;
        let across = difference(product(v[m], a[n]), product(v[n], a[m]));
        let around = sum(product(v[k], turn.cosine), product(across, sine));
        out[k] = sum(around, product(a[k], kept));
    }
    return out;
}

// A ray among things as they are at time 0, relative to the pivot; the parameter stays.
fn ray_at_begin(turn: Turn, source: Ray) -> Ray {
    var moved = source;
    var way: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        way[k] = difference(source.origin[k], turn.pivot[k]);
    }
    moved.origin = turned_about(turn, turn.sine, way);
    moved.direction = turned_about(turn, turn.sine, source.direction);
    return moved;
}

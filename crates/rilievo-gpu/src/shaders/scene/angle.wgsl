// Sines, cosines and arc tangents: the languages of shaders promise three digits only.

// Sine and cosine of x eighths of a turn, for |x| <= 1.
fn sin_cos_eighth(x: f32) -> vec2<f32> {
    let a = 0.25 * PI * x;
    let q = a * a;
    let s = 1.0 + q * (-1.6666667e-1 + q * (8.333333e-3 + q * (-1.9841270e-4 + q * 2.7557319e-6)));
    let c = q * (-0.5 + q * (4.1666667e-2 + q * (-1.3888889e-3 + q * 2.4801587e-5)));
    return vec2<f32>(a * s, 1.0 + c);
}

// Sine and cosine of a number of turns.
fn sin_cos_turns(turns: f32) -> vec2<f32> {
    let quarter = floor(4.0 * turns + 0.5);
    let e = sin_cos_eighth(2.0 * (4.0 * turns - quarter));
    switch i32(quarter) & 3 {
        case 0: { return e; }
        case 1: { return vec2<f32>(e.y, -e.x); }
        case 2: { return -e; }
        default: { return vec2<f32>(-e.y, e.x); }
    }
}

// The angle of a vector (cosine, sine) of any length, in [-pi, pi].
fn angle_of(p: vec2<f32>) -> f32 {
    let a = abs(p);
    let low = min(a.x, a.y);
    let high = max(max(a.x, a.y), 1e-37);
    var x = low / high;
    // tan(pi / 8)
    let far = x > 0.41421356;
    x = select(x, (x - 1.0) / (x + 1.0), far);
    let z = x * x;
    var angle = x + x * z * (-3.33329491539e-1
        + z * (1.99777106478e-1 + z * (-1.38776856032e-1 + z * 8.05374449538e-2)));
    angle += select(0.0, 0.25 * PI, far);
    angle = select(angle, 0.5 * PI - angle, a.y > a.x);
    angle = select(angle, PI - angle, p.x < 0.0);
    return select(angle, -angle, p.y < 0.0);
}

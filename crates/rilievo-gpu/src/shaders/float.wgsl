// Floats whose rounding is final.
//
// A driver may fuse a product with a sum, or cancel (a + b) - a: both change bits. `rounded` hides
// a value behind an integer operation with a number that only the CPU knows to be 0; whatever is
// shown to it is rounded as written, on every driver. The number comes with the rays: drivers look into
// uniforms, and compile what they find there.

// Always 0.
var<private> zero: u32;

fn rounded(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ zero);
}

fn rounded_four(x: vec4<f32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bitcast<vec4<u32>>(x) ^ vec4<u32>(zero));
}

fn larger(a: f32, b: f32) -> f32 {
    return select(b, a, a > b);
}

fn smaller(a: f32, b: f32) -> f32 {
    return select(b, a, a < b);
}

fn larger_four(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, a > b);
}

fn smaller_four(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, a < b);
}

// The float next above, no denormal.
fn next_up(x: f32) -> f32 {
    if abs(x) < 1.2e-38 {
        return 1.2e-38;
    }
    return bitcast<f32>(select(bitcast<u32>(x) - 1u, bitcast<u32>(x) + 1u, x > 0.0));
}

fn next_down(x: f32) -> f32 {
    return -next_up(-x);
}

// a / b rounded to the nearest, where a division may be off by 2.5 units in the last place.
fn quotient(a: f32, b: f32) -> f32 {
    let q = rounded(a / b);
    let p = two_product(q, b);
    return rounded(q + rounded(rounded(rounded(a - p.x) - p.y) / b));
}

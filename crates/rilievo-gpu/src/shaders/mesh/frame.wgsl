// The twin of `relief/mesh/frame.rs` in floats: a ray as a straight line in lattice coordinates, with a bounded
// remainder. Lattice coordinates count from the prism's own corner and parameters from where the ray passes
// its middle, so numbers are as small as the prism; what floats round is part of the remainder.

struct Path {
    start: vec3<f32>,
    speed: vec3<f32>,
    // Of the speed, and never infinite.
    inverse: vec3<f32>,
    error: vec3<f32>,
}

// Heights of reported roots lie up to this far outside of a region, relative to it, and what the products
// here round.
const WIDER: f32 = 1.00101;

// Larger numbers are taken for infinite.
const MOST: f32 = 1e30;

fn path_of(start: vec3<f32>, speed: vec3<f32>, error: vec3<f32>) -> Path {
    // What moves less over the prism counts as moving so much; the errors leave room for it.
    let least = max(0.05 * prism.noise / max(prism.span, 1e-30), vec3<f32>(1e-30));
    var kept = speed;
    for (var k = 0u; k < 3u; k++) {
        if abs(speed[k]) < least[k] {
            kept[k] = select(least[k], -least[k], speed[k] < 0.0);
        }
    }
    return Path(start, kept, 1.0 / kept, error);
}

fn path_at(path: Path, t: f32) -> vec3<f32> {
    return path.start + t * path.speed;
}

// The part of a span in which a path is between two corners, widened.
fn path_within(path: Path, span: vec2<f32>, low: vec3<f32>, high: vec3<f32>) -> vec2<f32> {
    let a = (low - path.error - path.start) * path.inverse;
    let b = (high + path.error - path.start) * path.inverse;
    let near = min(a, b);
    let far = max(a, b);
    return vec2<f32>(
        max(max(span.x, near.x), max(near.y, near.z)),
        min(min(span.y, far.x), min(far.y, far.z)),
    );
}

// The part of a span in which `start + t speed >= least`.
fn kept_span(span: vec2<f32>, start: f32, speed: f32, least: f32) -> vec2<f32> {
    let short = least - start;
    let t = short / speed;
    var kept = span;
    if speed > 0.0 {
        kept.x = max(kept.x, t);
    } else if speed < 0.0 {
        kept.y = min(kept.y, t);
    } else if short > 0.0 {
        kept.y = -MOST;
    }
    return kept;
}

fn inverse_of(m: mat3x3<f32>) -> mat3x3<f32> {
    let x = cross(m[1], m[2]);
    let y = cross(m[2], m[0]);
    let z = cross(m[0], m[1]);
    let per = 1.0 / dot(m[2], z);
    return transpose(mat3x3<f32>(x * per, y * per, z * per));
}

fn row_sums(m: mat3x3<f32>, v: vec3<f32>) -> vec3<f32> {
    return abs(m[0]) * v.x + abs(m[1]) * v.y + abs(m[2]) * v.z;
}

// The path of a frame about a box, made of the prism's own path; its error is infinite where there is none.
// `sign` turns the first two axes.
fn path_about(own: Path, sign: vec2<f32>, centre: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> Path {
    let turn = vec3<f32>(sign, 1.0);
    let a = sign.x * turn * prism.bend_x;
    let b = sign.y * turn * prism.bend_y;
    let middle = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    let k = middle - centre;
    let along = k.x * a + k.y * b;
    let jacobian = mat3x3<f32>(
        k.z * a + vec3<f32>(1.0, 0.0, 0.0),
        k.z * b + vec3<f32>(0.0, 1.0, 0.0),
        along + vec3<f32>(0.0, 0.0, 1.0),
    );
    let bent = k + k.z * along;
    let inverse = inverse_of(jacobian);
    let off = inverse * jacobian;
    let identity = mat3x3<f32>(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let left = row_sums(off - identity, half);
    // What the entries of the jacobian and the centre round.
    let rounded_part = row_sums(jacobian, half) + abs(k) + abs(k.z * along);
    let bend = (abs(inverse * a) * half.x + abs(inverse * b) * half.y) * half.z;
    let noise = prism.noise + 9.5367432e-7 * rounded_part;
    let error = (bend + left) * WIDER + 2.0 * row_sums(inverse, noise) + prism.noise;
    if !(error.x < MOST && error.y < MOST && error.z < MOST) {
        return Path(vec3<f32>(0.0), vec3<f32>(1.0), vec3<f32>(1.0), vec3<f32>(MOST));
    }
    return path_of(middle + inverse * (own.start - centre - bent), inverse * own.speed, error);
}

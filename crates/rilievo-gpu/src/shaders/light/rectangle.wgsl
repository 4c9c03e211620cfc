// The twin of `light/quad.rs` and `light/rectangle.rs`: a one-sided parallelogram, sampled by solid angle where it is a
// rectangle that looks crooked from the point, otherwise by area.

const FAR: f32 = 2.0;
const SMALL: f32 = 1e-4;

fn rotated(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(a.x * b.x - a.y * b.y, a.y * b.x + a.x * b.y);
}

// The inner angle between two neighbouring edges.
fn inner_angle(b0: f32, b1: f32, rest0: f32, rest1: f32) -> vec2<f32> {
    return vec2<f32>(-b0 * b1, sqrt(rest0 + b0 * b0 * rest1));
}

fn squared_nearest(x: vec2<f32>) -> f32 {
    let d = max(max(x.x, -x.y), 0.0);
    return d * d;
}

fn squared_farthest(x: vec2<f32>) -> f32 {
    let d = max(x.y, -x.x);
    return d * d;
}

// An edge of a quad in floats.
fn edge_of(light: u32, k: u32) -> vec3<f32> {
    let at = light + LIGHT_EDGES + 6u * k;
    return vec3<f32>(number(at), number(at + 2u), number(at + 4u));
}

fn view_quad(view: ptr<function, LightView>, light: u32) {
    let way = (*view).way;
    let distance = -dot(way, triple(light + LIGHT_NORMAL));
    (*view).visible = distance > 0.0;
    if !(*view).visible || scene[light + LIGHT_RECTANGULAR] == 0u {
        return;
    }
    let edges = array<vec3<f32>, 2>(edge_of(light, 0u), edge_of(light, 1u));
    let sides = vec2<f32>(length(edges[0]), length(edges[1]));
    let start = vec2<f32>(dot(way, edges[0]), dot(way, edges[1])) / sides;
    let x = vec2<f32>(start.x, start.x + sides.x);
    let y = vec2<f32>(start.y, start.y + sides.y);
    let upright = distance * distance;
    let far = squared_farthest(x) + squared_farthest(y) + upright;
    let near = squared_nearest(x) + squared_nearest(y) + upright;
    if far <= FAR * near {
        return;
    }
    let n = vec4<f32>(-y.x, x.y, y.y, -x.x);
    let squared = max(n * n + upright, vec4<f32>(1e-37));
    let b = n / sqrt(squared);
    let rest = upright / squared;
    let low = rotated(inner_angle(b.x, b.y, rest.x, rest.y), inner_angle(b.y, b.z, rest.y, rest.z));
    let high = rotated(inner_angle(b.z, b.w, rest.z, rest.w), inner_angle(b.w, b.x, rest.w, rest.x));
    let angle = angle_of(rotated(low, high));
    (*view).x = x;
    (*view).y = y;
    (*view).z = -distance;
    (*view).solid_angle = select(angle, angle + 2.0 * PI, angle < 0.0);
    (*view).b = b.xz;
    (*view).k = vec2<f32>(high.x, -high.y);
    (*view).solid = (*view).solid_angle >= SMALL;
}

// A point of a rectangle, from its corner along its edges, uniform by solid angle.
fn place_in_rectangle(view: LightView, u: vec2<f32>) -> vec2<f32> {
    let turn = sin_cos_turns(u.x * view.solid_angle / (2.0 * PI));
    let at = rotated(turn.yx, view.k);
    let sine = select(at.y, select(1e-30, -1e-30, at.y < 0.0), abs(at.y) < 1e-30);
    let f = clamp((at.x * view.b.x - view.b.y) / sine, -1e15, 1e15);
    let c = clamp(select(1.0, -1.0, f < 0.0) / sqrt(f * f + view.b.x * view.b.x), -1.0, 1.0);
    let x = clamp(-c * view.z / sqrt(max((1.0 - c) * (1.0 + c), 1e-37)), view.x.x, view.x.y);
    let d2 = x * x + view.z * view.z;
    let h0 = view.y.x / sqrt(d2 + view.y.x * view.y.x);
    let h1 = view.y.y / sqrt(d2 + view.y.y * view.y.y);
    let h = h0 + u.y * (h1 - h0);
    let y = clamp(h * sqrt(d2 / max((1.0 - h) * (1.0 + h), 1e-37)), view.y.x, view.y.y);
    return vec2<f32>(x - view.x.x, y - view.y.x);
}

fn sample_quad(light: u32, position: Place3, view: LightView, u: vec2<f32>) -> LightSample {
    if !view.solid {
        return sample_flat(light, position, u, 0.0);
    }
    let sides = vec2<f32>(length(edge_of(light, 0u)), length(edge_of(light, 1u)));
    return sample_flat(light, position, place_in_rectangle(view, u) / sides, view.solid_angle);
}

// How the words of a scene are read. `rilievo_render::device` writes them; the names of single words and the lengths
// of records are written before this by `shaders.rs`. Places are counted in words.

const PI: f32 = 3.14159265358979;
const LARGEST_BELOW_1: f32 = 0.99999994;
// Stands for what has no end.
const ENDLESS: f32 = 3e38;

fn number(place: u32) -> f32 {
    return bitcast<f32>(scene[place]);
}

fn triple(place: u32) -> vec3<f32> {
    return vec3<f32>(number(place), number(place + 1u), number(place + 2u));
}

fn double_in_scene(place: u32) -> Double {
    return Double(number(place), number(place + 1u));
}

alias Place3 = array<Double, 3>;

fn place_in_scene(place: u32) -> Place3 {
    return Place3(
        double_in_scene(place),
        double_in_scene(place + 2u),
        double_in_scene(place + 4u),
    );
}

// The way from one place to another, in floats.
fn way_between(a: Place3, b: Place3) -> vec3<f32> {
    return vec3<f32>(
        difference(b[0], a[0]).x,
        difference(b[1], a[1]).x,
        difference(b[2], a[2]).x,
    );
}

fn rough_place(a: Place3) -> vec3<f32> {
    return vec3<f32>(a[0].x, a[1].x, a[2].x);
}

// What is said of a surface: the places of its material and its form, IS_LIGHT, its kind, what its kind asks for, the
// first light that it is to paths, and the place of its transforms.
fn record_of(surface: u32) -> u32 {
    return scene[FIRST_SURFACE] + SURFACE_RECORD * surface;
}

fn material_of(surface: u32) -> u32 {
    return scene[record_of(surface)];
}

fn is_light(surface: u32) -> bool {
    return scene[record_of(surface) + 2u] != 0u;
}

fn largest_of(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

fn is_black(v: vec3<f32>) -> bool {
    return all(v == vec3<f32>(0.0));
}

// A unit vector, or another where there is no direction.
fn unit_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let largest = largest_of(abs(v));
    if !(largest > 0.0) || largest > ENDLESS {
        return other;
    }
    let scaled_down = v / largest;
    return scaled_down / length(scaled_down);
}

// Two directions at right angles with a unit vector and each other, as `glam` chooses them.
fn right_of(n: vec3<f32>) -> vec3<f32> {
    let sign = select(1.0, -1.0, (bitcast<u32>(n.z) >> 31u) == 1u);
    let a = -1.0 / (sign + n.z);
    return vec3<f32>(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x);
}

fn up_of(n: vec3<f32>) -> vec3<f32> {
    let sign = select(1.0, -1.0, (bitcast<u32>(n.z) >> 31u) == 1u);
    let a = -1.0 / (sign + n.z);
    return vec3<f32>(n.x * n.y * a, sign + n.y * n.y * a, -n.y);
}

// A direction of a frame whose z axis is a unit vector.
fn around(n: vec3<f32>, local: vec3<f32>) -> vec3<f32> {
    return local.x * right_of(n) + local.y * up_of(n) + local.z * n;
}

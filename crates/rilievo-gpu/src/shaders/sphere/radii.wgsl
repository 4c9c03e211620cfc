// The twin of `relief/sphere/radii.rs`: raw heights as the `q` of the projective frame. Distances count in
// radii of the middle of the relief, so that `q` lies around the number of cells for spheres of any size.

struct Radii {
    // Cells along a side of a face of the cube, and the first of its six faces.
    cells: u32,
    faces: u32,
    // Two balls between which the surface lies, scene units.
    inner: Double,
    outer: Double,
    // The middle of all radii, scene units.
    middle: Double,
    // Distance from the centre at raw height 0, and its change for one raw unit, in that middle.
    at_zero: Double,
    per_raw: Double,
    lift: f32,
    // Largest magnitude of a raw height.
    largest_raw: f32,
    // What a ray from outside, and one from inside, has to keep away from the surface in `sweep`.
    above: f32,
    beneath: f32,
}

var<private> radii: Radii;

fn read_radii(place: u32) {
    radii.inner = number_at(place + 6u);
    radii.outer = number_at(place + 8u);
    radii.middle = number_at(place + 10u);
    radii.at_zero = number_at(place + 12u);
    radii.per_raw = number_at(place + 14u);
    let floats = number_at(place + 16u);
    radii.lift = floats.x;
    radii.largest_raw = floats.y;
    let slacks = number_at(place + 18u);
    radii.above = slacks.x;
    radii.beneath = slacks.y;
    radii.cells = numbers[place + 20u];
    radii.faces = numbers[place + 21u];
}

// A whole number, exactly.
fn whole(x: u32) -> Double {
    return quick_two_sum(f32(x & 0xfffff000u), f32(x & 0xfffu));
}

// q at the corners h00, h10, h01, h11 of a cell of the face of the cube at hand.
fn radii_corners(cell: vec2<u32>) -> array<Double, 4> {
    let n = i32(radii.cells);
    var q: array<Double, 4>;
    for (var k = 0u; k < 4u; k++) {
        let at = cell + vec2<u32>(k & 1u, k >> 1u);
        let along = 2 * vec2<i32>(at) - n;
        let square = u32(along.x * along.x + along.y * along.y + n * n);
        let radius = sum(radii.at_zero, scaled(radii.per_raw, raw(at.x, at.y)));
        q[k] = ratio(root(whole(square)), radius);
    }
    return q;
}

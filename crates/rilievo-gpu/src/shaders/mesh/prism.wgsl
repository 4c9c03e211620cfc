// The twin of `relief/mesh/prism.rs` and `footprint.rs`: what a base triangle spans, as a ray meets it.

// By how much footprints and cells are widened, in cells.
const MARGIN: f32 = 9.5367432e-7;

const SPREAD: u32 = 1u;
const MIRRORED: u32 = 2u;
const SEES: u32 = 4u;

struct Prism {
    place: u32,
    flags: u32,
    // Unfolded cell from which lattice coordinates count, and the corners there.
    base: vec2<i32>,
    corners: array<vec2<f32>, 3>,
    // First cell and one past the last along each axis, unfolded.
    first: vec2<i32>,
    end: vec2<i32>,
    // Change of the second and third weight along x and y.
    weights: array<vec2<f32>, 2>,
    // Lowest and highest height.
    low: f32,
    high: f32,
    condition: f32,
    // The middle, and how the frame bends about it.
    centre: vec3<f32>,
    bend_x: vec3<f32>,
    bend_y: vec3<f32>,
    noise: vec3<f32>,
    // Parameter of the mesh's ray where it passes the middle; those of interest are within `span` of it.
    middle: f32,
    span: f32,
    // By how much later than the nearest a meeting may begin and yet be first.
    spare: f32,
}

var<private> prism: Prism;

fn matrix_at(place: u32) -> mat3x3<f32> {
    return mat3x3<f32>(floats_at(place), floats_at(place + 3u), floats_at(place + 6u));
}

// Reads a prism, and gives the ray in its frame. The prism's span is negative where the ray passes it by.
fn read_prism(index: u32) -> Path {
    let place = relief_mesh.prisms + PRISM_WORDS * index;
    prism.place = place;
    prism.flags = numbers[place + 3u];
    for (var k = 0u; k < 3u; k++) {
        prism.corners[k] =
            vec2<f32>(number_at(place + 4u + 4u * k).x, number_at(place + 6u + 4u * k).x);
    }
    for (var k = 0u; k < 2u; k++) {
        prism.base[k] = i32(numbers[place + 16u + k]);
        prism.first[k] = i32(numbers[place + 18u + 2u * k]);
        prism.end[k] = i32(numbers[place + 19u + 2u * k]);
        prism.weights[k] =
            vec2<f32>(number_at(place + 22u + 4u * k).x, number_at(place + 24u + 4u * k).x);
    }
    prism.low = float_at(place + 30u);
    prism.high = float_at(place + 31u);
    prism.condition = float_at(place + 32u);
    prism.centre = floats_at(place + 35u);
    let lattice_from_space = matrix_at(place + 44u);
    prism.bend_x = floats_at(place + 53u);
    prism.bend_y = floats_at(place + 56u);
    let error = floats_at(place + 59u);
    prism.noise = floats_at(place + 62u);
    let radius = float_at(place + 65u);
    let direction = in_floats(mesh_direction);
    var towards: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        towards[k] = difference(number_at(place + 38u + 2u * k), mesh_origin[k]);
    }
    let per_length = 1.0 / dot(direction, direction);
    prism.middle = dot(in_floats(towards), direction) * per_length;
    for (var k = 0u; k < 3u; k++) {
        towards[k] = difference(scaled(mesh_direction[k], prism.middle), towards[k]);
    }
    let passes = in_floats(towards);
    prism.span = radius * sqrt(per_length);
    prism.spare = float_at(place + 34u) / abs(along.x);
    let path = path_of(
        prism.centre + lattice_from_space * passes,
        lattice_from_space * direction,
        error,
    );
    if dot(passes, passes) > radius * radius {
        prism.span = -1.0;
    }
    return path;
}

// The latest parameter of interest, from the prism's middle.
fn prism_limit() -> f32 {
    let left = difference(mesh_limit, double(prism.middle)).x;
    return left + prism.spare + 2e-7 * abs(left) + 1e-6 * prism.span;
}

// The span of a path inside of the prism, widened.
fn clip_prism(path: Path) -> vec2<f32> {
    var span = vec2<f32>(-prism.span, min(prism.span, prism_limit()));
    span.x = max(span.x, -prism.middle - 1e-6 * (abs(prism.middle) + prism.span));
    let wide = vec2<f32>(MOST);
    span = path_within(
        path,
        span,
        vec3<f32>(-wide, prism.low - relief_mesh.height_slack),
        vec3<f32>(wide, prism.high + relief_mesh.height_slack),
    );
    let from_corner = path.start.xy - prism.corners[0];
    for (var k = 0u; k < 3u; k++) {
        var n = -prism.weights[0] - prism.weights[1];
        if k < 2u {
            n = prism.weights[k];
        }
        let start = dot(n, from_corner) + select(0.0, 1.0, k == 2u);
        let room = abs(n.x) * path.error.x + abs(n.y) * path.error.y;
        let slack = (abs(n.x) + abs(n.y)) * MARGIN + 1e-6 * prism.condition;
        span = kept_span(span, start, dot(n, path.speed.xy), -room - slack);
    }
    return span;
}

// First cell and one past the last of a row of cells that the widened footprint touches, counted from the prism's base.
fn footprint_row(row: f32) -> vec2<i32> {
    let size = max(abs(prism.corners[1] - prism.corners[0]), abs(prism.corners[2] - prism.corners[0]));
    let beside = MARGIN + 1e-6 * (size.x + size.y);
    let ends = vec2<f32>(row - beside, row + 1.0 + beside);
    var low = 1e9;
    var high = -1e9;
    for (var k = 0u; k < 3u; k++) {
        let p = prism.corners[k];
        let way = prism.corners[(k + 1u) % 3u] - p;
        // The part of the side that runs through the row.
        var part = vec2<f32>(0.0, 1.0);
        if way.y != 0.0 {
            let at = (ends - p.y) / way.y;
            part = clamp(vec2<f32>(min(at.x, at.y), max(at.x, at.y)) + vec2<f32>(-1e-6, 1e-6), vec2<f32>(0.0), vec2<f32>(1.0));
        }
        let y = p.y + part * way.y;
        if min(y.x, y.y) <= ends.y + beside && max(y.x, y.y) >= ends.x - beside {
            let x = p.x + part * way.x;
            low = min(low, min(x.x, x.y));
            high = max(high, max(x.x, x.y));
        }
    }
    return vec2<i32>(vec2<f32>(floor(low - beside), floor(high + beside) + 1.0));
}

// Whether a cell, counted from the prism's base, lies outside of the footprint.
fn misses_footprint(cell: vec2<f32>) -> bool {
    let a = prism.corners[0];
    let size = max(abs(prism.corners[1] - a), abs(prism.corners[2] - a));
    let beside = MARGIN + 1e-6 * (size.x + size.y);
    for (var k = 0u; k < 3u; k++) {
        let p = prism.corners[k];
        let q = prism.corners[(k + 1u) % 3u];
        let n = vec2<f32>(q.y - p.y, p.x - q.x);
        let values = vec3<f32>(0.0, dot(n, prism.corners[1] - a), dot(n, prism.corners[2] - a));
        let limit = max(values.x, max(values.y, values.z));
        let least = min(values.x, min(values.y, values.z));
        let low = n * (cell - a);
        let high = n * (cell + 1.0 - a);
        let slack = (abs(n.x) + abs(n.y)) * beside;
        let lowest = min(low.x, high.x) + min(low.y, high.y);
        let highest = max(low.x, high.x) + max(low.y, high.y);
        if lowest > limit + slack || highest < least - slack {
            return true;
        }
    }
    for (var k = 0u; k < 2u; k++) {
        let low = min(a[k], min(prism.corners[1][k], prism.corners[2][k]));
        let high = max(a[k], max(prism.corners[1][k], prism.corners[2][k]));
        if cell[k] > high + beside || cell[k] + 1.0 < low - beside {
            return true;
        }
    }
    return false;
}

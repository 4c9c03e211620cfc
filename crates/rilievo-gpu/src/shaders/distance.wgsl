// The twin of `relief/distance_walk.rs`: safe steps through a distance map in a 3-D texture, and the exact leaf near
// the surface. The paper's method where it was meant to run [Donnelly2005], made exact.
//
// The CPU steps in f64, this in f32. So every bound is widened by what f32 rounds. A place
// in cells is off by 5 units of 2^-24 of the numbers that it is made of, a border by 5 more, and the leaf strays by 8:
// 20 are allowed for. Heights get 2^-16 of their size, twice what the CPU gives them, lengths 2^-18 of themselves. Then
// the argument at the head of the CPU's walk holds: what is skipped holds nothing that the leaf would report, and
// the leaf is the same.

// Codes of all distance maps of the world, one above the other along z.
@group(3) @binding(0) var distances: texture_3d<u32>;

const BOXES: u32 = 0u;
const CORRECTED: u32 = 1u;
const PUBLISHED: u32 = 2u;

// The shortest step by a distance that is worth taking, in parameters.
const LEAST: f32 = 9.5367431640625e-7;
// How far past the border of a footprint a walk goes on, in parameters.
const BEYOND: f32 = 2.384185791015625e-7;

// A distance map, read from `bounds`.
struct DistanceMap {
    kind: u32,
    // First slice in the texture.
    slice: u32,
    // Voxels or nodes.
    size: vec3<u32>,
    // Voxels, or steps between nodes, per cell and per raw height.
    density: vec3<f32>,
    // Sides of a voxel, and the reference metric; in units of the map's largest side.
    sides: vec3<f32>,
    metric: vec3<f32>,
    quantum: f32,
    // First word of the heights of columns.
    columns: u32,
}

var<private> distance_map: DistanceMap;

fn number_in_bounds(place: u32) -> f32 {
    return bitcast<f32>(bound_word(place));
}

fn vector_in_bounds(place: u32) -> vec3<f32> {
    return vec3<f32>(number_in_bounds(place), number_in_bounds(place + 1u), number_in_bounds(place + 2u));
}

fn load_distance_map() {
    let at = shown_map.distance;
    distance_map.kind = bound_word(at);
    distance_map.slice = bound_word(at + 1u);
    distance_map.size = vec3<u32>(bound_word(at + 2u), bound_word(at + 3u), bound_word(at + 4u));
    distance_map.density = vector_in_bounds(at + 5u);
    distance_map.sides = vector_in_bounds(at + 8u);
    distance_map.metric = vector_in_bounds(at + 11u);
    distance_map.quantum = number_in_bounds(at + 14u);
    distance_map.columns = bound_word(at + 15u);
}

// Whether the face at hand is walked as the paper has it.
fn walks_published() -> bool {
    let at = shown_map.distance;
    if at >= MARCHED {
        return false;
    }
    return bound_word(at) == PUBLISHED;
}

fn code_at(voxel: vec3<u32>) -> f32 {
    let texel = vec3<u32>(voxel.xy, voxel.z + distance_map.slice);
    return f32(textureLoad(distances, vec3<i32>(texel), 0).x);
}

// The distance read at a place in steps of the grid, in the voxel that holds it.
fn distance_in(voxel: vec3<u32>, at: vec3<f32>) -> f32 {
    if distance_map.kind == BOXES {
        return code_at(voxel) * distance_map.quantum;
    }
    let local = clamp(at - vec3<f32>(voxel), vec3<f32>(0.0), vec3<f32>(1.0));
    var best = 0.0;
    var mean = 0.0;
    for (var k = 0u; k < 8u; k++) {
        let corner = vec3<u32>(k & 1u, (k >> 1u) & 1u, k >> 2u);
        let found = code_at(voxel + corner) * distance_map.quantum;
        let towards = select(1.0 - local, local, corner == vec3<u32>(1u));
        mean += towards.x * towards.y * towards.z * found;
        best = max(best, found - length((1.0 - towards) * distance_map.sides));
    }
    return select(best, mean, distance_map.kind == PUBLISHED);
}

// A tile as steps see it: places in steps of the grid are origin + s * direction.
struct Stepper {
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec2<f32>,
    // The border that is met next is that of the voxel plus this.
    next: vec2<f32>,
    last: vec3<f32>,
    per_height: f32,
    // What the heights of columns are widened by.
    lift: f32,
    // Parameters of one unit of distance, and of what may not be skipped.
    per_distance: f32,
    margin: f32,
}

fn away(x: f32) -> f32 {
    return select(x, 1e-30, abs(x) < 1e-30);
}

fn stepper_of(tile: Tile) -> Stepper {
    var at: Stepper;
    var origin: vec3<f32>;
    var slope: vec3<f32>;
    // What places along each axis are made of, in cells.
    var reach: vec2<f32>;
    for (var k = 0u; k < 2u; k++) {
        let sign = select(1.0, -1.0, tile.turn[k] != 0);
        origin[k] = sign * (f32(tile.origin[k]) + ray.o[k]);
        slope[k] = sign * ray.d[k];
        let window = max(abs(ray.lo[k]), abs(ray.hi[k]));
        let cells = f32(max(i32(shown_map.cells[k]), abs(tile.origin[k])));
        reach[k] = 1.0 + larger(window, cells);
    }
    origin.z = ray.oz - shown_map.low;
    slope.z = ray.dz;
    at.origin = origin * distance_map.density;
    at.direction = slope * distance_map.density;
    for (var k = 0u; k < 2u; k++) {
        let direction = away(at.direction[k]);
        at.inverse[k] = 1.0 / direction;
        at.next[k] = select(0.0, 1.0, direction > 0.0);
    }
    let least = select(2u, 1u, distance_map.kind == BOXES);
    at.last = vec3<f32>(distance_map.size - vec3<u32>(least));
    at.per_height = 1.0 / away(ray.dz);
    let size = max(shown_map.size, max(abs(ray.oz), abs(ray.oz + ray.dz)));
    let strays = 1.2e-6 * reach;
    let range = shown_map.high - shown_map.low;
    at.lift = 1.52587890625e-5 * size + (strays.x + strays.y) * range;
    at.per_distance = 0.999996 / length(distance_map.metric * slope);
    let margin = 1.52587890625e-5 * size * distance_map.metric.z
        + dot(strays, distance_map.metric.xy);
    at.margin = 1.00001 * margin * at.per_distance;
    return at;
}

// The first admitted crossing in a cell of a tile.
fn first_in_cell(tile: Tile, cell: vec2<i32>, admit: u32) -> LeafHit {
    let near = vec2<f32>(near_line(0u, cell.x), near_line(1u, cell.y));
    let far = vec2<f32>(far_line(0u, cell.x), far_line(1u, cell.y));
    let t0 = larger(larger(time_of(0u, near.x), time_of(1u, near.y)), 0.0);
    let t1 = smaller(smaller(time_of(0u, far.x), time_of(1u, far.y)), 1.0);
    if t0 >= t1 {
        return no_hit();
    }
    let enters = vec2<f32>(entering(0u, cell.x, t0), entering(1u, cell.y, t0));
    let leaves = vec2<f32>(leaving(0u, cell.x, t1), leaving(1u, cell.y, t1));
    var hit = first_root(gap_of(enters, leaves, t0, t1, tile_corners(tile, cell)), admit);
    if hit.found {
        hit.s = smaller(rounded(hit.s * rounded(t1 - t0)) + t0, t1);
        hit.cell = cell;
        hit.found = confirms(t0, hit, admit);
    }
    return hit;
}

// The cells of a tile that the ray meets between two parameters, one by one. Where nothing is hit, `s` tells where the
// last of them is left; -1 where the tile ends before.
fn first_in_cells(tile: Tile, first: f32, last: f32, admit: u32) -> LeafHit {
    var cell = clamp(vec2<i32>(cell_at(0u, first), cell_at(1u, first)), tile.first, tile.end - 1);
    loop {
        steps += 1u;
        var hit = first_in_cell(tile, cell, admit);
        if hit.found {
            return hit;
        }
        let far_x = time_of(0u, far_line(0u, cell.x));
        let far_y = time_of(1u, far_line(1u, cell.y));
        let leave = smaller(far_x, far_y);
        if leave > last {
            hit.s = leave;
            return hit;
        }
        cell += select(vec2<i32>(0), vec2<i32>(1), vec2<bool>(far_x <= leave, far_y <= leave));
        if cell.x >= tile.end.x || cell.y >= tile.end.y {
            hit.s = -1.0;
            return hit;
        }
    }
    return no_hit();
}

// The first admitted crossing in a tile between two parameters.
fn walk_distance(tile: Tile, begin: f32, end: f32, admit: u32) -> LeafHit {
    load_distance_map();
    let at = stepper_of(tile);
    var s = begin;
    while s < end {
        steps += 1u;
        let place = at.origin + s * at.direction;
        let voxel = vec3<u32>(clamp(place, vec3<f32>(0.0), at.last));
        let borders = (vec2<f32>(voxel.xy) + at.next - at.origin.xy) * at.inverse;
        let leave = smaller(borders.x, borders.y);
        let safe = s + distance_in(voxel, place) * at.per_distance - at.margin;
        if safe > larger(leave, s + LEAST) {
            s = safe;
            continue;
        }
        let stuck = leave <= s;
        var first = s;
        var last = s;
        if !stuck {
            let voxels = distance_map.size.x - select(1u, 0u, distance_map.kind == BOXES);
            let column = distance_map.columns + 2u * (voxel.y * voxels + voxel.x);
            let low = number_in_bounds(column) - at.lift;
            let high = number_in_bounds(column + 1u) + at.lift;
            let a = (low - ray.oz) * at.per_height;
            let b = (high - ray.oz) * at.per_height;
            first = larger(s, smaller(a, b) - BEYOND);
            // What begins before the walk goes on is shown: a ray through a corner may be in a cell for that long.
            last = smaller(leave, larger(a, b)) + BEYOND;
        }
        if first <= last {
            let hit = first_in_cells(tile, larger(first - BEYOND, begin), last, admit);
            if hit.found {
                return hit;
            }
            if hit.s < 0.0 {
                break;
            }
            s = larger(s, hit.s);
        }
        if !stuck {
            s = larger(s, leave + BEYOND);
        }
    }
    return no_hit();
}

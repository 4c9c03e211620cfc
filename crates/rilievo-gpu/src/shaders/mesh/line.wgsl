// The twin of `relief/mesh/line.rs`: a ray in the frame of a displaced mesh, from where it enters its box on,
// and what holds for the whole mesh. The shear is that of `triangle`.

struct ReliefMesh {
    // Raw heights are counted from here; no height is farther from it.
    level: f32,
    half_range: f32,
    // Height over the level that lies on the base.
    base: Double,
    // By how much heights of roots may lie outside of the bounds of their cell.
    height_slack: f32,
    // Length of a lift where nothing is steep: from any prism, and more for one by its condition.
    lift_start: f32,
    lift: f32,
    one_sided: bool,
    rises: bool,
    // Places in `numbers`, and how many prisms there are.
    vertices: u32,
    prisms: u32,
    walls: u32,
    count: u32,
    root: u32,
}

var<private> relief_mesh: ReliefMesh;

// The ray from the centre of the mesh, where it enters the box; its parameter there.
var<private> mesh_origin: array<Double, 3>;
var<private> mesh_direction: array<Double, 3>;
var<private> mesh_start: f32;

const VERTEX_WORDS: u32 = 12u;
const PRISM_WORDS: u32 = 66u;
const WALL_WORDS: u32 = 25u;

fn float_at(place: u32) -> f32 {
    return bitcast<f32>(numbers[place]);
}

fn floats_at(place: u32) -> vec3<f32> {
    return vec3<f32>(float_at(place), float_at(place + 1u), float_at(place + 2u));
}

// Makes a ray ready for the mesh at a place of `numbers`, which it leaves or not.
fn enter_mesh(source: Ray, place: u32, leaves: bool, slabs: SlabRay, t_max: Double) {
    relief_mesh.level = float_at(place + 6u);
    relief_mesh.half_range = float_at(place + 7u);
    relief_mesh.base = number_at(place + 8u);
    relief_mesh.height_slack = float_at(place + 10u);
    relief_mesh.lift_start = float_at(place + 11u);
    relief_mesh.lift = float_at(place + 19u);
    let flags = numbers[place + 12u];
    relief_mesh.one_sided = (flags & ONE_SIDED) != 0u;
    relief_mesh.rises = (flags & RISES) != 0u;
    show(numbers[place + 13u]);
    relief_mesh.vertices = numbers[place + 14u];
    relief_mesh.prisms = numbers[place + 15u];
    relief_mesh.walls = numbers[place + 16u];
    relief_mesh.count = numbers[place + 17u];
    relief_mesh.root = numbers[place + 18u];
    // The box of all parts that were joined: what is computed beside an edge is the same in both.
    mesh_start = max(entry(slabs, numbers[place + 20u], next_up(t_max.x)), 0.0);
    for (var k = 0u; k < 3u; k++) {
        let start = difference(source.origin[k], number_at(place + 2u * k));
        mesh_origin[k] = sum(start, scaled(source.direction[k], mesh_start));
    }
    mesh_direction = source.direction;
    if leaves {
        lift_start(source);
    }
    shear_ray(source);
    mesh_limit = difference(t_max, double(mesh_start));
    mesh_hit.surface = NOTHING;
    seen_prism = NOTHING;
}

// Place of a vertex in `numbers`: its base from the mesh's centre, and three doubles on its rise.
fn vertex_place(vertex: u32) -> u32 {
    return relief_mesh.vertices + VERTEX_WORDS * vertex;
}

// A vector at a place of `numbers` with the ray turned into the third axis; a point from its start on.
fn sheared_vector(place: u32, is_point: bool) -> array<Double, 3> {
    var v: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        let axis = axes[2u - k];
        var x = number_at(place + 2u * axis);
        if is_point {
            x = difference(x, mesh_origin[axis]);
        }
        if k > 0u {
            x = difference(x, product(shear[2u - k], v[2]));
        }
        v[2u - k] = x;
    }
    return v;
}

fn in_floats(v: array<Double, 3>) -> vec3<f32> {
    return vec3<f32>(v[0].x, v[1].x, v[2].x);
}

// Meets a prism or a wall; says whether that is the nearest so far.
fn meet_mesh_item(item: u32) -> bool {
    let before = mesh_limit;
    let had = mesh_hit.surface;
    if item < relief_mesh.count {
        walk_prism(item);
    } else {
        meet_wall(item - relief_mesh.count);
    }
    return below(mesh_limit, before) || had != mesh_hit.surface;
}

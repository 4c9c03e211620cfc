// What a dispatch is told, and what it reads and writes. `records.rs` writes and reads the structs field
// by field in this order.

struct Params {
    // 1 where each ray is answered by one word, whether it meets anything; else by a `Hit`.
    whether: u32,
    // First ray of this dispatch, and one past the last.
    first: u32,
    end: u32,
    // Surfaces of the world.
    surfaces: u32,
}

struct Ray {
    // Relative to the anchor of the scene.
    origin: array<Double, 3>,
    // Its largest component is at least 1 and below 2.
    direction: array<Double, 3>,
    t_max: Double,
    // From 0 to 1: where things are that move.
    time: Double,
    // The surface it leaves, or NOTHING.
    surface: u32,
    // Bits: FRONT, and the kind of wall it leaves from bit 8 up (1 + axis * 2 + high, 5 + axis for a seam, or 7 for a wall of
    // a mesh).
    leaves: u32,
    // The line of a seam; of a mesh the triangle or the wall.
    line: i32,
    // Always 0, which no compiler knows; see `rounded`.
    zero: u32,
    // A surface that it passes through, or NOTHING.
    exempt: u32,
    // Whether any hit will do.
    any: u32,
}

struct Hit {
    t: Double,
    // In the cell; for a wall nothing.
    local: array<Double, 2>,
    // Unfolded cell; the line of a seam in x.
    cell: vec2<i32>,
    // Or NOTHING.
    surface: u32,
    // Bits: FRONT, and the kind of wall from bit 8 up, as in a ray; of a displaced sphere the face of the
    // cube. The triangle is in cell.x.
    part: u32,
    steps: u32,
    // Triangle or wall of a displaced mesh.
    piece: u32,
}

// A displaced parallelogram and its map; the names are those of `relief::LatticeFrame`.
struct Face {
    // Row by row.
    lattice_from_world: array<Double, 9>,
    // Relative to the anchor of the scene.
    corner: array<Double, 3>,
    lattice_corner: array<Double, 3>,
    window_low: array<Double, 2>,
    window_high: array<Double, 2>,
    shell_low: array<Double, 3>,
    shell_high: array<Double, 3>,
    culled: array<Double, 2>,
    // Raw range of the map, and its largest magnitude.
    low: f32,
    high: f32,
    size: f32,
    lift: f32,
    // Value of a bound's code 0, and of one code step.
    code_base: f32,
    code_step: f32,
    raw_zero: f32,
    // Bits: RISES, CLOSED, ONE_SIDED, FLOATS.
    flags: u32,
    samples: vec2<u32>,
    // Stored cells, along each axis.
    cells: vec2<u32>,
    // 1 for a texel lattice; 0 repeat, 1 clamp, 2 mirror.
    texel: u32,
    wrap: u32,
    // Where the map's samples begin, and the table of its pyramid, in words.
    heights: u32,
    bounds: u32,
    levels: u32,
    // Where its distance map is told of in `bounds`, or NOTHING, or MARCHED for fixed steps.
    distance: u32,
}

// A surface of the world.
struct Surface {
    kind: u32,
    // Of a face: its place in `faces`. Of a sphere: the place of centre and radius in `numbers`. Of
    // triangles: the root of their tree. Of a displaced sphere or mesh: its place in
    // `numbers`.
    data: u32,
    // Place in `numbers` of the matrix, row by row, and the translation that bring the world to its own
    // frame; NOTHING where that is the world.
    transform: u32,
    // ONE_SIDED, MOVES: a `Motion` follows the transform, which counts from its pivot.
    flags: u32,
}

// A box, grown by what its users round, and what is in it.
struct Node {
    low: array<f32, 3>,
    high: array<f32, 3>,
    // Of an inner node the second child, the first follows it. Of a leaf of the world the surface; of a
    // leaf of a mesh the place of the first triangle in `numbers`.
    first: u32,
    // Triangles or surfaces; 0 for an inner node.
    count: u32,
}

const NOTHING: u32 = 0xffffffffu;
const MARCHED: u32 = 0xfffffffeu;

const FRONT: u32 = 1u;
const WALL_SHIFT: u32 = 8u;

const FACE: u32 = 1u;
const SPHERE: u32 = 2u;
const TRIANGLES: u32 = 3u;
const RELIEF_SPHERE: u32 = 4u;
const RELIEF_MESH: u32 = 5u;

const RISES: u32 = 1u;
const CLOSED: u32 = 2u;
const ONE_SIDED: u32 = 4u;
const FLOATS: u32 = 8u;
const MOVES: u32 = 16u;

const REPEAT: u32 = 0u;
const CLAMP: u32 = 1u;
const MIRROR: u32 = 2u;

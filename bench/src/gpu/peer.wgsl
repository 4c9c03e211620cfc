// The nearest hit of every ray in a binary tree over triangles, both children's boxes in their parent, nearer child
// first, a stack of its own for every ray [Aila2009]; triangles by Moeller and Trumbore [Moeller1997].

struct Ray {
    origin: vec3<f32>,
    t_max: f32,
    direction: vec3<f32>,
    unused: f32,
}

struct Found {
    // Infinite where nothing is hit.
    t: f32,
    triangle: u32,
}

@group(0) @binding(0) var<storage, read> rays: array<Ray>;
@group(0) @binding(1) var<storage, read_write> found: array<Found>;
// Floats but for w. Four a node: low and high corner of the first child's box, then of the second's. In w of the low corner where
// the child is: a node, or its first triangle; in w of the high one its triangles, 0 for a node.
@group(0) @binding(2) var<storage, read> nodes: array<vec4<u32>>;
// Three a triangle: a corner and the edges that start there.
@group(0) @binding(3) var<storage, read> triangles: array<vec4<f32>>;

const STACK: u32 = 64u;
const FAR: f32 = 3e38;

// Where a ray enters a box, or FAR.
fn entry(low_bits: vec3<u32>, high_bits: vec3<u32>, origin: vec3<f32>, inverse: vec3<f32>, t: f32) -> f32 {
    let a = (bitcast<vec3<f32>>(low_bits) - origin) * inverse;
    let b = (bitcast<vec3<f32>>(high_bits) - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    let leave = min(min(far.x, far.y), min(far.z, t));
    return select(FAR, enter, enter <= leave * 1.0000004);
}

fn meet(triangle: u32, origin: vec3<f32>, direction: vec3<f32>, best: Found) -> Found {
    let corner = triangles[3u * triangle].xyz;
    let edge_1 = triangles[3u * triangle + 1u].xyz;
    let edge_2 = triangles[3u * triangle + 2u].xyz;
    let p = cross(direction, edge_2);
    let determinant = dot(edge_1, p);
    let inverse = 1.0 / determinant;
    let to = origin - corner;
    let u = dot(to, p) * inverse;
    let q = cross(to, edge_1);
    let v = dot(direction, q) * inverse;
    let t = dot(edge_2, q) * inverse;
    if determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t < best.t {
        return Found(t, triangle);
    }
    return best;
}

@compute @workgroup_size(64)
fn closest(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = id.y * groups.x * 64u + id.x;
    if at >= arrayLength(&rays) {
        return;
    }
    let origin = rays[at].origin;
    let direction = rays[at].direction;
    let straight = abs(direction) < vec3<f32>(1e-20);
    let inverse = 1.0 / select(direction, vec3<f32>(1e-20), straight);
    var best = Found(min(rays[at].t_max, FAR), 0xffffffffu);
    var stack: array<u32, STACK>;
    var size = 0u;
    var node = 0u;
    loop {
        let low_1 = nodes[4u * node];
        let high_1 = nodes[4u * node + 1u];
        let low_2 = nodes[4u * node + 2u];
        let high_2 = nodes[4u * node + 3u];
        var enter_1 = entry(low_1.xyz, high_1.xyz, origin, inverse, best.t);
        var enter_2 = entry(low_2.xyz, high_2.xyz, origin, inverse, best.t);
        let child_1 = low_1.w;
        let child_2 = low_2.w;
        let count_1 = high_1.w;
        let count_2 = high_2.w;
        if count_1 > 0u && enter_1 < FAR {
            for (var k = 0u; k < count_1; k++) {
                best = meet(child_1 + k, origin, direction, best);
            }
            enter_1 = FAR;
        }
        if count_2 > 0u && enter_2 < best.t {
            for (var k = 0u; k < count_2; k++) {
                best = meet(child_2 + k, origin, direction, best);
            }
            enter_2 = FAR;
        }
        let goes_1 = count_1 == 0u && enter_1 < FAR;
        let goes_2 = count_2 == 0u && enter_2 < FAR;
        if goes_1 && goes_2 {
            let first_is_nearer = enter_1 <= enter_2;
            stack[min(size, STACK - 1u)] = select(child_1, child_2, first_is_nearer);
            size += 1u;
            node = select(child_2, child_1, first_is_nearer);
        } else if goes_1 {
            node = child_1;
        } else if goes_2 {
            node = child_2;
        } else if size > 0u {
            size -= 1u;
            node = stack[min(size, STACK - 1u)];
        } else {
            break;
        }
    }
    if best.triangle == 0xffffffffu {
        best.t = FAR;
    }
    found[at] = best;
}

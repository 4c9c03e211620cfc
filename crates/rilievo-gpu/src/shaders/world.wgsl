// The twin of `surface/world.rs` and `accel/traverse.rs`: the tree over the surfaces of the world, and
// under it those of meshes and of what instances show, nearer nodes first.

// No tree is deeper, and a tree may stand under another.
const DEPTH: u32 = 128u;

// What the boxes are told of a ray, in floats.
struct SlabRay {
    // As the smaller and as the larger faces see it.
    low: vec3<f32>,
    high: vec3<f32>,
    inverse: vec3<f32>,
}

fn slab_ray(source: Ray) -> SlabRay {
    var o: vec3<f32>;
    var inverse: vec3<f32>;
    for (var k = 0u; k < 3u; k++) {
        o[k] = source.origin[k].x;
        let d = source.direction[k].x;
        inverse[k] = select(1.0 / d, select(1e30, -1e30, d < 0.0), abs(d) < 1e-30);
    }
    let spread = 5e-7 * max(abs(o.x), max(abs(o.y), abs(o.z)));
    return SlabRay(o + spread, o - spread, inverse);
}

// Where the ray enters a box, or a negative number.
fn entry(at: SlabRay, node: u32, t_max: f32) -> f32 {
    let box_low = vec3<f32>(nodes[node].low[0], nodes[node].low[1], nodes[node].low[2]);
    let box_high = vec3<f32>(nodes[node].high[0], nodes[node].high[1], nodes[node].high[2]);
    let a = (box_low - at.low) * at.inverse;
    let b = (box_high - at.high) * at.inverse;
    let backwards = at.inverse < vec3<f32>(0.0);
    let enter = select(a, b, backwards);
    let leave = select(b, a, backwards);
    let near = max(max(enter.x, enter.y), max(enter.z, 0.0));
    let far = min(min(leave.x, leave.y), min(leave.z, t_max)) * 1.000002;
    return select(-1.0, near, near <= far);
}

// A ray in the frame of a surface; the parameter stays.
fn local_ray(source: Ray, place: u32) -> Ray {
    var local = source;
    for (var k = 0u; k < 3u; k++) {
        var row: array<Double, 3>;
        for (var m = 0u; m < 3u; m++) {
            row[m] = number_at(place + 6u * k + 2u * m);
        }
        local.origin[k] = sum(dot_double(row, source.origin), number_at(place + 18u + 2u * k));
        local.direction[k] = dot_double(row, source.direction);
    }
    return local;
}

fn vector_at(place: u32) -> array<Double, 3> {
    return array<Double, 3>(number_at(place), number_at(place + 2u), number_at(place + 4u));
}

// The motion at a place of `numbers`.
fn motion_at(place: u32) -> Motion {
    return Motion(
        vector_at(place),
        vector_at(place + 6u),
        vector_at(place + 12u),
        number_at(place + 18u),
    );
}

// A surface that rays pass through, or NOTHING.
var<private> ignored: u32 = NOTHING;

// The nearest hit of all surfaces, or any.
fn nearest(source: Ray) -> Hit {
    var best: Hit;
    best.surface = NOTHING;
    if params.surfaces == 0u {
        return best;
    }
    var t_max = source.t_max;
    var local = source;
    var slabs = slab_ray(source);
    // The mesh whose tree is being walked, and where the stack stood before.
    var mesh = NOTHING;
    var floor_of_mesh = 0u;
    var stack: array<u32, DEPTH>;
    var size = 0u;
    if entry(slabs, 0u, next_up(t_max.x)) >= 0.0 {
        stack[0] = 0u;
        size = 1u;
    }
    while size > 0u {
        if mesh != NOTHING && size == floor_of_mesh {
            mesh = NOTHING;
            local = source;
            slabs = slab_ray(source);
        }
        size -= 1u;
        let node = stack[size];
        // A nearer hit may have been found since.
        let limit = next_up(t_max.x);
        if entry(slabs, node, limit) < 0.0 {
            continue;
        }
        steps += 1u;
        let first = nodes[node].first;
        let count = nodes[node].count;
        if count == 0u {
            let near = entry(slabs, node + 1u, limit);
            let far = entry(slabs, first, limit);
            if size + 2u > DEPTH {
                continue;
            }
            let swapped = far >= 0.0 && far < near;
            if near >= 0.0 && swapped {
                stack[size] = node + 1u;
                size += 1u;
            }
            if far >= 0.0 {
                stack[size] = first;
                size += 1u;
            }
            if near >= 0.0 && !swapped {
                stack[size] = node + 1u;
                size += 1u;
            }
            continue;
        }
        if mesh != NOTHING && surfaces[mesh].kind == RELIEF_MESH {
            if RELIEF_MESHES {
                if meet_mesh_item(first) {
                    best = mesh_hit;
                    best.t = sum(mesh_hit.t, double(mesh_start));
                    best.surface = mesh;
                    t_max = best.t;
                    if source.any != 0u {
                        return best;
                    }
                }
            }
            continue;
        }
        if mesh != NOTHING {
            let leaves = source.surface == mesh;
            for (var k = 0u; k < count; k++) {
                let place = first + k * 20u;
                if leaves && source.line == i32(numbers[place + 18u]) {
                    continue;
                }
                let one_sided = (surfaces[mesh].flags & ONE_SIDED) != 0u;
                let hit = meet_triangle(place, t_max, one_sided);
                let ties = hit.t.x == best.t.x && hit.t.y == best.t.y;
                if hit.surface != NOTHING && !(ties && best.surface == mesh && best.cell.x < hit.cell.x) {
                    best = hit;
                    best.surface = mesh;
                    t_max = hit.t;
                    if source.any != 0u {
                        return best;
                    }
                }
            }
            continue;
        }
        let number = first;
        if number == ignored {
            continue;
        }
        local = source;
        if surfaces[number].transform != NOTHING {
            let place = surfaces[number].transform;
            if MOVING && (surfaces[number].flags & MOVES) != 0u {
                local = ray_at_begin(turn_at(motion_at(place + 24u), source.time), source);
            }
            local = local_ray(local, place);
        }
        var hit: Hit;
        hit.surface = NOTHING;
        switch surfaces[number].kind {
            case FACE: {
                // `shaders.rs` writes which displaced surfaces there are; drivers drop the others.
                if FACES {
                    show(surfaces[number].data);
                    hit = meet_face(local, t_max, number);
                }
            }
            case RELIEF_MESH: {
                if RELIEF_MESHES {
                    mesh = number;
                    floor_of_mesh = size;
                    slabs = slab_ray(local);
                    let leaves = source.surface == number;
                    enter_mesh(local, surfaces[number].data, leaves, slabs, t_max);
                    stack[size] = relief_mesh.root;
                    size += 1u;
                }
            }
            case RELIEF_SPHERE: {
                if RELIEF_SPHERES {
                    let leaves = source.surface == number;
                    hit = meet_relief_sphere(local, t_max, surfaces[number].data, leaves);
                }
            }
            case SPHERE: {
                hit = meet_sphere(local, t_max, surfaces[number].data, source.surface == number);
            }
            case TRIANGLES: {
                mesh = number;
                floor_of_mesh = size;
                slabs = slab_ray(local);
                shear_ray(local);
                stack[size] = surfaces[number].data;
                size += 1u;
            }
            default: {}
        }
        if hit.surface != NOTHING {
            let ties = best.surface != NOTHING && hit.t.x == best.t.x && hit.t.y == best.t.y;
            if !(ties && best.surface < number) {
                best = hit;
                best.surface = number;
                t_max = hit.t;
                if source.any != 0u {
                    return best;
                }
            }
        }
    }
    return best;
}

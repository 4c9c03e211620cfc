// The twin of `relief/mesh/departure.rs`: the start of a ray that leaves a displaced mesh is lifted along the
// displacement. Only the direction of the lift is searched, so floats are enough.

// The factors of two vectors whose sum comes nearest to a third.
fn least_squares(u: vec3<f32>, v: vec3<f32>, to: vec3<f32>) -> vec2<f32> {
    let uu = dot(u, u);
    let uv = dot(u, v);
    let vv = dot(v, v);
    let step = vec2<f32>(vv * dot(u, to) - uv * dot(v, to), uu * dot(v, to) - uv * dot(u, to));
    let area = uu * vv - uv * uv;
    if area <= 0.0 {
        return vec2<f32>(0.0);
    }
    return step / area;
}

// The unit vector, or none for one without length.
fn unit_of(v: vec3<f32>) -> vec3<f32> {
    let largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    if largest <= 0.0 {
        return vec3<f32>(0.0);
    }
    return normalize(v / largest);
}

// Lifts the start of a ray off the triangle or wall that it leaves.
fn lift_start(source: Ray) {
    let on_wall = (source.leaves >> WALL_SHIFT) == SEAM_WALL;
    var triangle = u32(source.line);
    var wall = 0u;
    if on_wall {
        wall = relief_mesh.walls + WALL_WORDS * triangle;
        triangle = numbers[wall + 2u];
    }
    let place = relief_mesh.prisms + PRISM_WORDS * triangle;
    var ends = vec3<u32>(numbers[place], numbers[place + 1u], numbers[place + 2u]);
    if on_wall {
        ends = vec3<u32>(numbers[wall], numbers[wall + 1u], numbers[wall]);
    }
    let a = vertex_place(ends.x);
    let b = vertex_place(ends.y);
    let c = vertex_place(ends.z);
    let rise = rise_of(a);
    let e = between_places(a, b);
    let f = between_places(a, c);
    let turn_e = between_places(a + 6u, b + 6u);
    let turn_f = between_places(a + 6u, c + 6u);
    var from_corner: array<Double, 3>;
    for (var k = 0u; k < 3u; k++) {
        from_corner[k] = difference(mesh_origin[k], number_at(a + 2u * k));
    }
    let point = in_floats(from_corner);
    // Weights of the second and third corner, and the height.
    var at = vec3<f32>(1.0 / 3.0, 1.0 / 3.0, 0.5 * (float_at(place + 30u) + float_at(place + 31u)));
    if on_wall {
        at = vec3<f32>(0.5, 0.0, 0.0);
    }
    var shell: mat3x3<f32>;
    for (var k = 0; k < 8; k++) {
        shell = mat3x3<f32>(
            e + at.z * turn_e,
            f + at.z * turn_f,
            rise + at.x * turn_e + at.y * turn_f,
        );
        let off = point - at.x * e - at.y * f - at.z * shell[2];
        if on_wall {
            let step = least_squares(shell[0], shell[2], off);
            at.x = clamp(at.x + step.x, 0.0, 1.0);
            at.z += step.y;
        } else {
            let step = inverse_of(shell) * off;
            if !(abs(step.x) < MOST && abs(step.y) < MOST && abs(step.z) < MOST) {
                break;
            }
            at += step;
            let weights = clamp(at.xy, vec2<f32>(0.0), vec2<f32>(1.0));
            at = vec3<f32>(weights / max(weights.x + weights.y, 1.0), at.z);
        }
    }
    let rounding = relief_mesh.lift_start + float_at(place + 32u) * relief_mesh.lift;
    let length = (1.0 + float_at(place + 33u)) * rounding;
    let up = unit_of(shell[2]);
    var direction = up;
    if on_wall {
        let heights = wall_heights(wall, double(at.x));
        let normal = wall_normal(wall, at.x, at.z, !below(heights[0], heights[1]));
        direction = unit_of(normal) + select(-up, up, relief_mesh.rises);
    } else if dot(shell[2], cross(shell[0], shell[1])) < 0.0 {
        direction = -up;
    }
    if (source.leaves & FRONT) == 0u {
        direction = -direction;
    }
    for (var k = 0u; k < 3u; k++) {
        mesh_origin[k] = sum(mesh_origin[k], double(length * direction[k]));
    }
}

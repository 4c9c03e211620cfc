// The twin of `relief/mesh/hit.rs`: points of displaced meshes. `forms/mesh.rs` writes what is read here.

const SHELL_SPREAD: u32 = 1u;
const SHELL_MIRRORED: u32 = 2u;
const SHELL_AUTHORED: u32 = 4u;

// The kind of wall in `part` and `leaves`.
const MESH_WALL: u32 = 7u;

// From the place of one vector of doubles to that of another, in floats.
fn between_in_scene(a: u32, b: u32) -> vec3<f32> {
    var way: vec3<f32>;
    for (var k = 0u; k < 3u; k++) {
        way[k] = difference(double_in_scene(b + 2u * k), double_in_scene(a + 2u * k)).x;
    }
    return way;
}

fn within_unit(x: Double) -> Double {
    return smaller_double(larger_double(x, double(0.0)), double(1.0));
}

// A point of a wall: a place along its edge, and a height.
fn point_of_mesh_wall(hit: Hit, source: Ray, form: u32) -> Point {
    var point: Point;
    let wall = scene[form + 13u] + SHELL_WALL_FORM * hit.piece;
    let s = within_unit(hit.local[0]);
    var rise: vec3<f32>;
    for (var k = 0u; k < 3u; k++) {
        // Of the base and the displacement.
        var mixed: array<Double, 2>;
        for (var part = 0u; part < 2u; part++) {
            let at = wall + 12u * part + 2u * k;
            let a = double_in_scene(at);
            mixed[part] = sum(a, product(s, difference(double_in_scene(at + 6u), a)));
        }
        rise[k] = mixed[1].x;
        let raised = sum(mixed[0], product(hit.local[1], mixed[1]));
        point.position[k] = sum(double_in_scene(form + 2u * k), raised);
    }
    let along = between_in_scene(wall, wall + 6u)
        + hit.local[1].x * between_in_scene(wall + 12u, wall + 18u);
    // Towards the side that is lower: that of the ray where it met the front.
    let normal = unit_or(cross(along, rise), vec3<f32>(0.0, 0.0, 1.0));
    let towards = dot(normal, rough_direction(source)) < 0.0;
    point.geometric = select(-normal, normal, towards == ((hit.part & FRONT) != 0u));
    point.shading = point.geometric;
    let a = vec2<f32>(number(wall + 24u), number(wall + 25u));
    let b = vec2<f32>(number(wall + 26u), number(wall + 27u));
    point.uv = mix(a, b, s.x);
    let shell = scene[form + 12u] + SHELL_FORM * scene[wall + 28u];
    // The base triangle's edges.
    let g = vec2<f32>(number(shell + 59u), number(shell + 60u));
    let h = vec2<f32>(number(shell + 61u), number(shell + 62u));
    let along_u = triple(shell + 63u);
    let along_v = triple(shell + 66u);
    let spans = (scene[shell + 56u] & SHELL_SPREAD) != 0u;
    point.along_u = select(along_u, g.x * along_u + g.y * along_v, spans);
    point.along_v = select(along_v, h.x * along_u + h.y * along_v, spans);
    point.wall = MESH_WALL;
    point.line = i32(hit.piece);
    return point;
}

// A point of the sheet of a triangle at weights of its second and third corner and a height over the level, and the
// displacement there.
struct ShellPlace {
    position: Place3,
    rise: vec3<f32>,
}

fn shell_place(form: u32, shell: u32, weights: array<Double, 2>, height: Double) -> ShellPlace {
    var out: ShellPlace;
    for (var k = 0u; k < 3u; k++) {
        // Of the base and the displacement.
        var mixed: array<Double, 2>;
        for (var part = 0u; part < 2u; part++) {
            let at = shell + 18u * part + 2u * k;
            let a = double_in_scene(at);
            let e = product(weights[0], difference(double_in_scene(at + 6u), a));
            let f = product(weights[1], difference(double_in_scene(at + 12u), a));
            mixed[part] = sum(a, sum(e, f));
        }
        out.rise[k] = mixed[1].x;
        let raised = sum(mixed[0], product(height, mixed[1]));
        out.position[k] = sum(double_in_scene(form + 2u * k), raised);
    }
    return out;
}

// The point over a place of a base triangle.
fn place_on_shell(form: u32, face_of_map: u32, index: u32, weights: vec2<f32>) -> Place3 {
    show(face_of_map);
    let shell = scene[form + 12u] + SHELL_FORM * index;
    var cell: vec2<i32>;
    var local: array<Double, 2>;
    for (var k = 0u; k < 2u; k++) {
        let along = sum(
            scaled(double_in_scene(shell + 40u + 2u * k), weights.x),
            scaled(double_in_scene(shell + 44u + 2u * k), weights.y),
        );
        let at = sum(double_in_scene(shell + 36u + 2u * k), along);
        cell[k] = i32(floored(at));
        local[k] = difference(at, double(floored(at)));
    }
    let height = difference(raw_in_cell(cell, local), double(number(form + 6u)));
    let both = array<Double, 2>(double(weights.x), double(weights.y));
    return shell_place(form, shell, both, height).position;
}

// A point of a triangle whose map is that of a face.
fn point_of_shell(hit: Hit, form: u32, face_of_map: u32) -> Point {
    var point: Point;
    show(face_of_map);
    let shell = scene[form + 12u] + SHELL_FORM * hit.piece;
    let flags = scene[shell + 56u];
    let spread = (flags & SHELL_SPREAD) != 0u;
    var weights = hit.local;
    var local = hit.local;
    var gradients: array<vec2<f32>, 2>;
    // From the first corner, in cells.
    var from_corner: array<Double, 2>;
    for (var k = 0u; k < 2u; k++) {
        let corner = difference(double(f32(hit.cell[k])), double_in_scene(shell + 36u + 2u * k));
        from_corner[k] = sum(corner, hit.local[k]);
        if !spread {
            let e = product(double_in_scene(shell + 40u + 2u * k), hit.local[0]);
            let f = product(double_in_scene(shell + 44u + 2u * k), hit.local[1]);
            local[k] = difference(sum(e, f), corner);
        }
        local[k] = within_unit(local[k]);
    }
    for (var k = 0u; k < 2u; k++) {
        let x = double_in_scene(shell + 48u + 4u * k);
        let y = double_in_scene(shell + 50u + 4u * k);
        gradients[k] = vec2<f32>(x.x, y.x);
        if spread {
            weights[k] = sum(product(x, from_corner[0]), product(y, from_corner[1]));
        }
        weights[k] = within_unit(weights[k]);
    }
    let height = difference(raw_in_cell(hit.cell, local), double(number(form + 6u)));
    let sheet = shell_place(form, shell, weights, height);
    let rise = sheet.rise;
    point.position = sheet.position;
    let h = unfolded_corners(hit.cell);
    let place = vec2<f32>(local[0].x, local[1].x);
    let bend = (h.w - h.z) - (h.y - h.x);
    let slope = vec2<f32>(h.y - h.x + bend * place.y, h.z - h.x + bend * place.x);
    // Edges at the height of the point, and along the surface.
    var edges: array<vec3<f32>, 2>;
    var along: array<vec3<f32>, 2>;
    for (var k = 0u; k < 2u; k++) {
        let end = shell + 6u + 6u * k;
        edges[k] = between_in_scene(shell, end) + height.x * between_in_scene(shell + 18u, end + 18u);
        let run = vec2<f32>(number(shell + 40u + 4u * k), number(shell + 42u + 4u * k));
        along[k] = edges[k] + dot(slope, run) * rise;
    }
    point.geometric = unit_or(cross(along[0], along[1]), triple(shell + 69u));
    if spread {
        point.spread = abs(dot(cross(edges[0], edges[1]), rise) / dot(point.geometric, rise));
    }
    point.shading = point.geometric;
    let v = weights[0].x;
    let w = weights[1].x;
    let kind = scene[form + 7u];
    if kind != EXACT && spread {
        let tx = gradients[0].x * edges[0] + gradients[1].x * edges[1];
        let ty = gradients[0].y * edges[0] + gradients[1].y * edges[1];
        let unit_height = number(form + 11u);
        let metric = vec2<f32>(length(tx), length(ty));
        var steepness = abs(unit_height) / metric;
        if scene[form + 8u] != 0u {
            steepness = vec2<f32>(number(form + 9u), number(form + 10u));
        }
        let n = normalize(map_normal(kind, steepness, hit.cell, place));
        // Offsets per cell along the unit displacement.
        let offsets = -sign(unit_height) * n.xy / max(n.z, 1e-9) * metric;
        let up = rise / unit_height;
        var normal: vec3<f32>;
        if (flags & SHELL_AUTHORED) != 0u {
            let mixed = (1.0 - v - w) * triple(shell + 72u) + v * triple(shell + 75u)
                + w * triple(shell + 78u);
            let m = unit_or(mixed, vec3<f32>(0.0));
            let over = offsets * dot(up, m);
            normal = m * dot(m, cross(tx, ty)) - over.x * cross(ty, m) - over.y * cross(m, tx);
        } else {
            normal = cross(tx + offsets.x * up, ty + offsets.y * up);
        }
        normal = unit_or(normal, point.geometric);
        normal = select(normal, -normal, (flags & SHELL_MIRRORED) != 0u);
        let usable = all(metric > vec2<f32>(0.0)) && dot(normal, point.geometric) > 0.0;
        point.shading = select(point.geometric, normal, usable);
    }
    let a = vec2<f32>(number(shell + 57u), number(shell + 58u));
    let b = vec2<f32>(number(shell + 59u), number(shell + 60u));
    let c = vec2<f32>(number(shell + 61u), number(shell + 62u));
    point.uv = a + v * b + w * c;
    point.along_u = triple(shell + 63u);
    point.along_v = triple(shell + 66u);
    point.line = i32(hit.piece);
    return point;
}

fn point_of_relief_mesh(hit: Hit, source: Ray, form: u32, face_of_map: u32) -> Point {
    if (hit.part >> WALL_SHIFT) == MESH_WALL {
        return point_of_mesh_wall(hit, source, form);
    }
    return point_of_shell(hit, form, face_of_map);
}

// The twin of `surface/quad.rs`, `surface/sphere.rs`, `spherical.rs` and `mesh/triangle.rs`: points of what is not
// displaced.

// A triangle of a mesh or a quad, by its number: weights from its place, and what they mix.
fn point_of_triangle(hit: Hit, source: Ray, form: u32) -> Point {
    var point: Point;
    let triangle = form + 1u + TRIANGLE_FORM * u32(hit.cell.x);
    point.line = hit.cell.x;
    point.position = place_along(source, hit.t);
    let way = way_between(place_in_scene(triangle), point.position);
    let e = triple(triangle + 6u);
    let f = triple(triangle + 9u);
    // Vectors in the plane that are 1 along one edge and 0 along the other.
    let v = dot(way, triple(triangle + 12u));
    let w = dot(way, triple(triangle + 15u));
    point.geometric = triple(triangle + 18u);
    point.spread = length(cross(e, f));
    let flags = scene[triangle + 36u];
    point.shading = point.geometric;
    if (flags & 1u) != 0u {
        let mixed = (1.0 - v - w) * triple(triangle + 21u) + v * triple(triangle + 24u)
            + w * triple(triangle + 27u);
        let normal = unit_or(mixed, point.geometric);
        point.shading = select(normal, -normal, dot(normal, point.geometric) < 0.0);
    }
    let a = vec2<f32>(number(triangle + 30u), number(triangle + 31u));
    let g = vec2<f32>(number(triangle + 32u), number(triangle + 33u));
    let h = vec2<f32>(number(triangle + 34u), number(triangle + 35u));
    point.uv = a + v * g + w * h;
    // Quads keep to their square.
    if (flags & 2u) != 0u {
        point.uv = clamp(point.uv, vec2<f32>(0.0), vec2<f32>(1.0));
    }
    let area = g.x * h.y - g.y * h.x;
    point.along_u = e;
    point.along_v = f;
    if abs(area) > 1e-30 {
        point.along_u = (h.y * e - g.y * f) / area;
        point.along_v = (g.x * f - h.x * e) / area;
    }
    return point;
}

// Parameters in a direction from the centre of a sphere.
fn spherical_uv(outward: vec3<f32>) -> vec2<f32> {
    let turns = angle_of(outward.xy) / (2.0 * PI);
    var u = select(turns, turns + 1.0, turns < 0.0);
    if u >= 1.0 || all(outward.xy == vec2<f32>(0.0)) {
        u = 0.0;
    }
    let latitude = angle_of(vec2<f32>(length(outward.xy), outward.z));
    return vec2<f32>(u, clamp(0.5 + latitude / PI, 0.0, 1.0));
}

fn add_spherical(point: ptr<function, Point>, radius: f32, outward: vec3<f32>) {
    let level = length(outward.xy);
    let meridian = select(vec2<f32>(1.0, 0.0), outward.xy / max(level, 1e-30), level > 1e-30);
    (*point).uv = spherical_uv(outward);
    (*point).along_u = 2.0 * PI * radius * vec3<f32>(-outward.y, outward.x, 0.0);
    (*point).along_v = PI * radius * vec3<f32>(-outward.z * meridian, level);
}

fn point_of_sphere(hit: Hit, source: Ray, form: u32) -> Point {
    var point: Point;
    let center = place_in_scene(form);
    let radius = double_in_scene(form + 6u);
    let met = place_along(source, hit.t);
    var arm: Place3;
    for (var k = 0u; k < 3u; k++) {
        arm[k] = difference(met[k], center[k]);
    }
    let squared = sum(sum(product(arm[0], arm[0]), product(arm[1], arm[1])), product(arm[2], arm[2]));
    let stretch = ratio(radius, root(squared));
    for (var k = 0u; k < 3u; k++) {
        point.position[k] = sum(center[k], product(arm[k], stretch));
    }
    point.geometric = unit_or(rough_place(arm), vec3<f32>(0.0, 0.0, 1.0));
    point.shading = point.geometric;
    add_spherical(&point, radius.x, point.geometric);
    return point;
}

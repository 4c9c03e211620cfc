// The twin of `relief/mesh/patch.rs`: one cell of the map under one base triangle, as a ray sees it. Cells over
// triangles whose uv span an area have cell coordinates for parameters, others barycentric weights; one
// patch serves both.

// Twice what a double rounds.
const DOUBLE_ROUNDING: f32 = 1.4210855e-14;

// The prism as the ray sees it: base and rise of the first corner, and their change along both parameters.
var<private> seen: array<array<Double, 3>, 6>;
// Bound on what a value is off by.
var<private> seen_rounding: f32;
var<private> seen_prism: u32;

fn see_prism() {
    var sizes: array<f32, 2>;
    for (var part = 0u; part < 2u; part++) {
        var corners: array<array<Double, 3>, 3>;
        for (var k = 0u; k < 3u; k++) {
            let vertex = vertex_place(numbers[prism.place + k]);
            corners[k] = sheared_vector(vertex + 6u * part, part == 0u);
            let v = abs(in_floats(corners[k]));
            sizes[part] = max(sizes[part], max(v.x, max(v.y, v.z)));
        }
        seen[part] = corners[0];
        for (var m = 0u; m < 3u; m++) {
            let e = difference(corners[1][m], corners[0][m]);
            let f = difference(corners[2][m], corners[0][m]);
            seen[2u + part][m] = e;
            seen[4u + part][m] = f;
            if (prism.flags & SPREAD) != 0u {
                for (var k = 0u; k < 2u; k++) {
                    let g = number_at(prism.place + 22u + 2u * k);
                    let h = number_at(prism.place + 26u + 2u * k);
                    seen[2u + 2u * k + part][m] = sum(product(g, e), product(h, f));
                }
            }
        }
    }
    let size = sizes[0] + relief_mesh.half_range * sizes[1];
    seen_rounding = 32.0 * DOUBLE_ROUNDING * prism.condition * size;
    seen_prism = prism.place;
}

// Value and derivatives along both parameters, with bounds on the sizes of what these sum.
struct Local {
    value: array<Double, 3>,
    x: vec3<f32>,
    y: vec3<f32>,
    sizes_x: vec3<f32>,
    sizes_y: vec3<f32>,
    // Bound on the distance between patch and tangent plane over the box.
    bend: vec3<f32>,
}

struct MeshPatch {
    // Height `a + b x + c y + d x y` over the level.
    heights: array<Double, 4>,
    // Cell coordinates are `corner + u edge_x + v edge_y`.
    corner: array<Double, 2>,
    edge_x: array<Double, 2>,
    edge_y: array<Double, 2>,
    // Base and rise at (0, 0).
    base: array<Double, 3>,
    rise: array<Double, 3>,
    low: array<Double, 2>,
    high: array<Double, 2>,
}

var<private> mesh_patch: MeshPatch;

// Heights of a cell over the level, by powers.
fn heights_over(corners: vec4<f32>) -> array<Double, 4> {
    let first = two_sum(corners.x, -relief_mesh.level);
    let along_x = two_sum(corners.y, -corners.x);
    let along_y = two_sum(corners.z, -corners.x);
    let twist = difference(two_sum(corners.w, -corners.z), along_x);
    return array<Double, 4>(first, along_x, along_y, twist);
}

fn height_of(h: array<Double, 4>, x: Double, y: Double) -> Double {
    return sum(sum(h[0], product(h[1], x)), product(sum(h[2], product(h[3], x)), y));
}

// The patch of an unfolded cell.
fn make_patch(cell: vec2<i32>) {
    if seen_prism != prism.place {
        see_prism();
    }
    mesh_patch.heights = heights_over(unfolded_corners(cell));
    let spread = (prism.flags & SPREAD) != 0u;
    for (var k = 0u; k < 2u; k++) {
        let first = f32(cell[k] - prism.base[k]);
        let a = difference(number_at(prism.place + 4u + 2u * k), double(first));
        let b = difference(number_at(prism.place + 8u + 2u * k), double(first));
        let c = difference(number_at(prism.place + 12u + 2u * k), double(first));
        mesh_patch.corner[k] = a;
        mesh_patch.edge_x[k] = difference(b, a);
        mesh_patch.edge_y[k] = difference(c, a);
        mesh_patch.low[k] = double(-9.0949470e-13);
        mesh_patch.high[k] = double(1.0 + 1.1920929e-7);
        if spread {
            mesh_patch.corner[k] = double(0.0);
            mesh_patch.edge_x[k] = double(select(0.0, 1.0, k == 0u));
            mesh_patch.edge_y[k] = double(select(0.0, 1.0, k == 1u));
            // The part of the cell in the box of the triangle.
            let least = smaller_double(smaller_double(a, b), c);
            let most = larger_double(larger_double(a, b), c);
            mesh_patch.low[k] =
                sum(smaller_double(larger_double(least, double(0.0)), double(1.0)), mesh_patch.low[k]);
            mesh_patch.high[k] =
                sum(smaller_double(larger_double(most, double(0.0)), double(1.0)), double(9.0949470e-13));
            // The cell's corner from the triangle's.
            let u = -a;
            for (var m = 0u; m < 3u; m++) {
                var base = seen[0][m];
                var rise = seen[1][m];
                if k > 0u {
                    base = mesh_patch.base[m];
                    rise = mesh_patch.rise[m];
                }
                mesh_patch.base[m] = sum(base, product(u, seen[2u + 2u * k][m]));
                mesh_patch.rise[m] = sum(rise, product(u, seen[3u + 2u * k][m]));
            }
        } else {
            mesh_patch.base = seen[0];
            mesh_patch.rise = seen[1];
        }
    }
}

fn local_patch(middle: array<Double, 2>, half: vec2<f32>) -> Local {
    var local: Local;
    var at: array<Double, 2>;
    var e: vec2<f32>;
    var f: vec2<f32>;
    for (var k = 0u; k < 2u; k++) {
        e[k] = mesh_patch.edge_x[k].x;
        f[k] = mesh_patch.edge_y[k].x;
        let along_x = product(middle[0], mesh_patch.edge_x[k]);
        at[k] = sum(mesh_patch.corner[k], sum(along_x, product(middle[1], mesh_patch.edge_y[k])));
    }
    let height = height_of(mesh_patch.heights, at[0], at[1]);
    let d = mesh_patch.heights[3].x;
    let slope = vec2<f32>(
        mesh_patch.heights[1].x + d * at[1].x,
        mesh_patch.heights[2].x + d * at[0].x,
    );
    let slope_size = vec2<f32>(
        abs(mesh_patch.heights[1].x) + abs(d * at[1].x),
        abs(mesh_patch.heights[2].x) + abs(d * at[0].x),
    );
    let slope_u = dot(slope, e);
    let slope_v = dot(slope, f);
    var rise: vec3<f32>;
    for (var m = 0u; m < 3u; m++) {
        let n = sum(product(middle[0], seen[3][m]), product(middle[1], seen[5][m]));
        let p = sum(product(middle[0], seen[2][m]), product(middle[1], seen[4][m]));
        let up = sum(mesh_patch.rise[m], n);
        rise[m] = up.x;
        local.value[m] = sum(sum(mesh_patch.base[m], p), product(height, up));
    }
    let pu = in_floats(seen[2]);
    let pv = in_floats(seen[4]);
    let nu = in_floats(seen[3]);
    let nv = in_floats(seen[5]);
    local.x = pu + height.x * nu + slope_u * rise;
    local.y = pv + height.x * nv + slope_v * rise;
    let high = abs(height.x);
    local.sizes_x = abs(pu) + high * abs(nu) + dot(slope_size, abs(e)) * abs(rise);
    local.sizes_y = abs(pv) + high * abs(nv) + dot(slope_size, abs(f)) * abs(rise);
    let h_uu = 2.0 * abs(d * e.x * e.y);
    let h_uv = abs(d) * (abs(e.x * f.y) + abs(e.y * f.x));
    let h_vv = 2.0 * abs(d * f.x * f.y);
    let steep_u = abs(slope_u) + h_uu * half.x + h_uv * half.y;
    let steep_v = abs(slope_v) + h_uv * half.x + h_vv * half.y;
    let risen = abs(rise) + half.x * abs(nu) + half.y * abs(nv);
    local.bend = 1.00001 * (half.x * half.x * (steep_u * abs(nu) + 0.5 * h_uu * risen)
        + half.x * half.y * (h_uv * risen + steep_u * abs(nv) + steep_v * abs(nu))
        + half.y * half.y * (steep_v * abs(nv) + 0.5 * h_vv * risen));
    return local;
}

// Whether a point known to within `error` may belong to the closed cell and the closed triangle.
fn patch_holds(at: array<Double, 2>, cell: vec2<i32>, error: vec2<f32>) -> bool {
    let spread = (prism.flags & SPREAD) != 0u;
    var off_cell = error;
    for (var k = 0u; k < 2u; k++) {
        var x = at[k];
        if !spread {
            off_cell[k] = MARGIN + error.x * abs(mesh_patch.edge_x[k].x)
                + error.y * abs(mesh_patch.edge_y[k].x);
            let edges = sum(product(at[0], mesh_patch.edge_x[k]), product(at[1], mesh_patch.edge_y[k]));
            x = sum(mesh_patch.corner[k], edges);
        }
        if x.x < 0.0 && -x.x > off_cell[k] || difference(x, double(1.0)).x > off_cell[k] {
            return false;
        }
    }
    var weights = at;
    var off = error + DOUBLE_ROUNDING * prism.condition;
    var off_total = off.x + off.y;
    if spread {
        for (var k = 0u; k < 2u; k++) {
            let place = prism.place + 22u + 4u * k;
            weights[k] = double(0.0);
            for (var m = 0u; m < 2u; m++) {
                let first = f32(cell[m] - prism.base[m]);
                let corner = difference(double(first), number_at(prism.place + 4u + 2u * m));
                let g = number_at(place + 2u * m);
                weights[k] = sum(weights[k], product(g, sum(corner, at[m])));
            }
            let g = abs(prism.weights[k]);
            off[k] = dot(g, error) + 4.0 * DOUBLE_ROUNDING * prism.condition;
        }
        let both = abs(prism.weights[0] + prism.weights[1]);
        // The sum of both may cancel; its floats are off by what they round.
        let spare = 2e-7 * (abs(prism.weights[0]) + abs(prism.weights[1]));
        off_total = dot(both + spare, error) + 4.0 * DOUBLE_ROUNDING * prism.condition;
    }
    let first = difference(double(1.0), sum(weights[0], weights[1]));
    return weights[0].x >= -off.x && weights[1].x >= -off.y && first.x >= -off_total;
}

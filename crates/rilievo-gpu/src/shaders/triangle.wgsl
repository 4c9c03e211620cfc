// The twin of `mesh/crossing.rs` in doubles: vertices are sheared so that the ray becomes an axis, and
// three edge functions say on which side of each edge it passes.

// The minor axes and the one along which the ray is longest; they keep handedness.
var<private> axes: vec3<u32>;
var<private> shear: array<Double, 2>;
var<private> along: Double;
var<private> start: array<Double, 3>;

struct Sheared {
    x: Double,
    y: Double,
    depth: Double,
}

fn shear_ray(source: Ray) {
    var z = 0u;
    var largest = abs(source.direction[0].x);
    for (var k = 1u; k < 3u; k++) {
        if abs(source.direction[k].x) > largest {
            z = k;
            largest = abs(source.direction[k].x);
        }
    }
    var x = (z + 1u) % 3u;
    var y = (z + 2u) % 3u;
    along = source.direction[z];
    if along.x < 0.0 {
        let swapped = x;
        x = y;
        y = swapped;
    }
    axes = vec3<u32>(x, y, z);
    shear[0] = ratio(source.direction[x], along);
    shear[1] = ratio(source.direction[y], along);
    start = source.origin;
}

fn number_at(place: u32) -> Double {
    return Double(bitcast<f32>(numbers[place]), bitcast<f32>(numbers[place + 1u]));
}

fn sheared(place: u32) -> Sheared {
    let depth = difference(number_at(place + 2u * axes.z), start[axes.z]);
    let x = difference(number_at(place + 2u * axes.x), start[axes.x]);
    let y = difference(number_at(place + 2u * axes.y), start[axes.y]);
    return Sheared(
        difference(x, product(shear[0], depth)),
        difference(y, product(shear[1], depth)),
        depth,
    );
}

// Twice the signed area of the origin, q and p.
fn edge(p: Sheared, q: Sheared) -> Double {
    return difference(product(p.x, q.y), product(p.y, q.x));
}

// The crossing with the triangle at a place of `numbers`, within [0, t_max].
fn meet_triangle(place: u32, t_max: Double, one_sided: bool) -> Hit {
    var hit: Hit;
    hit.surface = NOTHING;
    let a = sheared(place);
    let b = sheared(place + 6u);
    let c = sheared(place + 12u);
    let u = edge(c, b);
    let v = edge(a, c);
    let w = edge(b, a);
    let falls = u.x < 0.0 || v.x < 0.0 || w.x < 0.0;
    let rises = u.x > 0.0 || v.x > 0.0 || w.x > 0.0;
    let total = sum(sum(u, v), w);
    if (falls && rises) || is_zero(total) || (one_sided && falls) {
        return hit;
    }
    let weighted = sum(sum(product(u, a.depth), product(v, b.depth)), product(w, c.depth));
    hit.t = ratio(ratio(weighted, total), along);
    if hit.t.x < 0.0 || below(t_max, hit.t) {
        return hit;
    }
    hit.surface = 0u;
    hit.cell.x = i32(numbers[place + 18u]);
    hit.part = select(0u, FRONT, rises);
    return hit;
}

// The twin of `relief/mesh/leaf.rs`: where a ray first meets a patch, by Krawczyk's operator. Values are
// doubles, derivatives and remainders floats; what these round counts as remainder.

// Half size of an enclosure that is small enough, and one that is too large, in parameters.
const FINE: f32 = 3.6379788e-12;
const COARSE: f32 = 1.5258789e-5;

// A step that leaves more of a side is followed by a cut.
const SHRINK: f32 = 0.45;

// Cuts, and evaluations, after which a box is taken for a root; and a size below which none is cut.
const CUTS: u32 = 40u;
const EVALUATIONS: u32 = 500u;
const SMALLEST: f32 = 9.5367432e-7;

// The nearest meeting: no other counts beyond it. Parameters are those of the mesh's ray.
var<private> mesh_limit: Double;
var<private> mesh_hit: Hit;

// Shows an unfolded cell to the leaf; the nearest root becomes the hit if it is nearer than all others.
fn leaf_of_mesh(cell: vec2<i32>, index: u32) {
    make_patch(cell);
    let winding = select(1.0, -1.0, (prism.flags & MIRRORED) != 0u);
    let delta = seen_rounding;
    var low = mesh_patch.low;
    var high = mesh_patch.high;
    // Far halves that wait.
    var waiting: array<vec4<f32>, CUTS>;
    var depths: array<u32, CUTS>;
    var count = 0u;
    var depth = 0u;
    var evaluations = 0u;
    // Half sizes of an enclosure that is small enough: one more evaluation takes it.
    var enclosed = vec2<f32>(-1.0);
    loop {
        var middle: array<Double, 2>;
        var half: vec2<f32>;
        for (var k = 0u; k < 2u; k++) {
            middle[k] = scaled(sum(low[k], high[k]), 0.5);
            half[k] = 0.500001 * max(difference(high[k], low[k]).x, 0.0);
        }
        let local = local_patch(middle, half);
        evaluations += 1u;
        steps += 1u;
        var done = false;
        let turn = local.x.x * local.y.y - local.x.y * local.y.x;
        if enclosed.x >= 0.0 {
            done = true;
            let t = ratio(local.value[2], along);
            let wanted = !relief_mesh.one_sided || -winding * turn >= 0.0;
            // A later root at the same parameter is not nearer.
            let nearer = below(t, mesh_limit)
                || (mesh_hit.surface == NOTHING && at_most(t, mesh_limit));
            if t.x >= 0.0 && nearer && wanted && patch_holds(middle, cell, enclosed) {
                mesh_limit = t;
                mesh_hit.t = t;
                mesh_hit.local = middle;
                mesh_hit.cell = cell;
                mesh_hit.part = select(0u, FRONT, turn * winding < 0.0);
                mesh_hit.piece = index;
                mesh_hit.surface = 0u;
            }
            enclosed = vec2<f32>(-1.0);
        } else {
            let f = in_floats(local.value);
            let sizes = local.sizes_x * half.x + local.sizes_y * half.y;
            let room = 1.00001 * (sizes + local.bend + delta);
            let ends = vec2<f32>(f.z - room.z, f.z + room.z) / along.x;
            let slack = 1e-6 * abs(f.z / along.x);
            done = abs(f.x) > room.x || abs(f.y) > room.y
                || max(ends.x, ends.y) < -slack || min(ends.x, ends.y) > mesh_limit.x + slack;
            let exhausted = depth >= CUTS || evaluations >= EVALUATIONS || count >= CUTS;
            var cuts = !done;
            let inverse = 1.0 / turn;
            if !done && abs(inverse) < MOST {
                let yx = vec2<f32>(local.y.y, -local.y.x) * inverse;
                let yy = vec2<f32>(-local.x.y, local.x.x) * inverse;
                let back = vec2<f32>(dot(yx, f.xy), dot(yy, f.xy));
                let w = local.bend.xy + delta;
                let unit = vec2<f32>(dot(abs(yx), sizes.xy), dot(abs(yy), sizes.xy));
                let passed = vec2<f32>(dot(abs(yx), abs(f.xy)), dot(abs(yy), abs(f.xy)));
                var error = 1.00001 * vec2<f32>(dot(abs(yx), w), dot(abs(yy), w))
                    + 2e-6 * (unit + passed) + DOUBLE_ROUNDING;
                if max(error.x, error.y) < MOST {
                    var shrunk = true;
                    for (var k = 0u; k < 2u; k++) {
                        let found = sum(middle[k], double(-back[k]));
                        low[k] = larger_double(low[k], sum(found, double(-error[k])));
                        high[k] = smaller_double(high[k], sum(found, double(error[k])));
                        let left = difference(high[k], low[k]).x;
                        done = done || left < 0.0;
                        shrunk = shrunk && left < SHRINK * 2.0 * half[k];
                        error[k] = min(error[k], left);
                    }
                    let noise = vec2<f32>(abs(yx.x) + abs(yx.y), abs(yy.x) + abs(yy.y));
                    let fine = min(FINE + 4.0 * delta * noise, vec2<f32>(COARSE));
                    if !done && error.x <= fine.x && error.y <= fine.y {
                        enclosed = error;
                        cuts = false;
                    } else if done || (shrunk && !exhausted) {
                        cuts = false;
                    }
                }
            }
            let size = vec2<f32>(difference(high[0], low[0]).x, difference(high[1], low[1]).x);
            if cuts && (exhausted || max(size.x, size.y) < SMALLEST) {
                for (var k = 0u; k < 2u; k++) {
                    enclosed[k] = 0.5 * size[k];
                }
            } else if cuts {
                let moves = vec2<f32>(
                    max(abs(local.x.x), abs(local.x.y)) * size.x,
                    max(abs(local.y.x), abs(local.y.y)) * size.y,
                );
                // Where the ray sees neither side move, the longer one.
                let side = select(
                    select(0u, 1u, moves.y > moves.x),
                    select(0u, 1u, size.y > size.x),
                    moves.x == moves.y,
                );
                let cut = scaled(sum(low[side], high[side]), 0.5);
                // The half that waits is rounded outward.
                var far = vec4<f32>(
                    next_down(low[0].x),
                    next_down(low[1].x),
                    next_up(high[0].x),
                    next_up(high[1].x),
                );
                let steep = select(local.x.z, local.y.z, side == 1u);
                if steep / along.x < 0.0 {
                    far[2u + side] = next_up(cut.x);
                    low[side] = cut;
                } else {
                    far[side] = next_down(cut.x);
                    high[side] = cut;
                }
                depth += 1u;
                waiting[count] = far;
                depths[count] = depth;
                count += 1u;
            }
        }
        if done {
            if count == 0u {
                break;
            }
            count -= 1u;
            let next = waiting[count];
            depth = depths[count];
            for (var k = 0u; k < 2u; k++) {
                low[k] = double(next[k]);
                high[k] = double(next[2u + k]);
            }
            enclosed = vec2<f32>(-1.0);
        } else if enclosed.x >= 0.0 {
            // The next evaluation is at the root.
            for (var k = 0u; k < 2u; k++) {
                low[k] = scaled(sum(low[k], high[k]), 0.5);
                high[k] = low[k];
            }
        }
    }
}

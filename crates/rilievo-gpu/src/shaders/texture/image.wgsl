// The twin of `texture/mod.rs` and `texture/image.rs`: images laid over surfaces.

const SRGB_CODES: u32 = 0u;
const LINEAR_CODES: u32 = 1u;

// What one sample covers of a surface.
struct Footprint {
    uv: vec2<f32>,
    width: vec2<f32>,
}

struct Neighbours {
    first: u32,
    next: u32,
    part: f32,
}

fn neighbours_clamped(u: f32, texels: u32) -> Neighbours {
    let last = texels - 1u;
    let x = clamp(u * f32(texels) - 0.5, 0.0, f32(last));
    let i = u32(x);
    return Neighbours(i, min(i + 1u, last), x - f32(i));
}

fn neighbours(u: f32, texels: u32, wrap: u32) -> Neighbours {
    if wrap == REPEAT {
        let x = (u - floor(u)) * f32(texels) - 0.5;
        let first = floor(x);
        let i = u32((i32(first) + i32(texels)) % i32(texels));
        return Neighbours(i, select(i + 1u, 0u, i + 1u == texels), x - first);
    }
    if wrap == CLAMP {
        return neighbours_clamped(u, texels);
    }
    let turn = (0.5 * u - floor(0.5 * u)) * 2.0;
    return neighbours_clamped(select(turn, 2.0 - turn, turn > 1.0), texels);
}

// The colour of the texel `at` places after the first of an image.
fn texel(coding: u32, texels: u32, at: u32) -> vec3<f32> {
    let floats = coding > LINEAR_CODES;
    let place = texels + select(at, 3u * at, floats);
    let codes = scene[place];
    var colour: vec3<f32>;
    for (var channel = 0u; channel < 3u; channel++) {
        let code = (codes >> (8u * channel)) & 255u;
        if coding == LINEAR_CODES {
            colour[channel] = f32(code) / 255.0;
        } else {
            colour[channel] = number(select(scene[SRGB_TABLE] + code, place + channel, floats));
        }
    }
    return colour;
}

// The linear colour of a texture, on average over a footprint. Every texel is read in one place.
fn mean_colour(texture: u32, at: Footprint) -> vec3<f32> {
    let image = scene[texture];
    let tile = vec2<f32>(number(texture + 1u), number(texture + 2u));
    let turn = vec2<f32>(number(texture + 3u), number(texture + 4u));
    let p = at.uv * tile;
    let turned = vec2<f32>(turn.x * p.x - turn.y * p.y, turn.y * p.x + turn.x * p.y);
    let place = turned + vec2<f32>(number(texture + 5u), number(texture + 6u));
    let wrap = vec2<u32>(scene[texture + 7u], scene[texture + 8u]);
    let w = abs(at.width * tile);
    let t = abs(turn);
    let width = vec2<f32>(t.x * w.x + t.y * w.y, t.y * w.x + t.x * w.y);
    let side = min(width.x * f32(scene[image + 2u]), width.y * f32(scene[image + 3u]));
    let last = scene[image + 1u] - 1u;
    let depth = log2(max(side, 1.0));
    let fine = min(floor(depth), 64.0);
    // The share of the coarser of two images that halve each other.
    var coarser = depth - fine;
    if u32(fine) >= last || coarser < 1e-3 {
        coarser = 0.0;
    }
    let coding = scene[image];
    var colour = vec3<f32>(0.0);
    for (var k = 0u; k < select(1u, 2u, coarser > 0.0); k++) {
        let level = image + 2u + 3u * min(u32(fine) + k, last);
        let columns = scene[level];
        let x = neighbours(place.x, columns, wrap.x);
        let y = neighbours(place.y, scene[level + 1u], wrap.y);
        let share = select(1.0 - coarser, coarser, k == 1u);
        for (var corner = 0u; corner < 4u; corner++) {
            let right = (corner & 1u) == 1u;
            let above = corner > 1u;
            let weight = select(1.0 - x.part, x.part, right) * select(1.0 - y.part, y.part, above);
            let row = select(y.first, y.next, above);
            let one = texel(coding, scene[level + 2u], row * columns + select(x.first, x.next, right));
            colour += share * weight * one;
        }
    }
    return colour;
}

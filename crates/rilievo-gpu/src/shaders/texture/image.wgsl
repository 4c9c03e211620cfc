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

fn texel(coding: u32, texels: u32, at: u32) -> vec3<f32> {
    if coding > LINEAR_CODES {
        return triple(texels + 3u * at);
    }
    let word = scene[texels + at];
    let codes = vec3<u32>(word & 255u, (word >> 8u) & 255u, (word >> 16u) & 255u);
    if coding == LINEAR_CODES {
        return vec3<f32>(codes) / 255.0;
    }
    let table = scene[SRGB_TABLE];
    return vec3<f32>(number(table + codes.x), number(table + codes.y), number(table + codes.z));
}

// The colour at a place of one of the images that halve each other.
fn lookup_level(image: u32, level: u32, p: vec2<f32>, wrap: vec2<u32>) -> vec3<f32> {
    let at = image + 2u + 3u * min(level, scene[image + 1u] - 1u);
    let columns = scene[at];
    let x = neighbours(p.x, columns, wrap.x);
    let y = neighbours(p.y, scene[at + 1u], wrap.y);
    let coding = scene[image];
    let texels = scene[at + 2u];
    let low = mix(
        texel(coding, texels, y.first * columns + x.first),
        texel(coding, texels, y.first * columns + x.next),
        x.part,
    );
    let high = mix(
        texel(coding, texels, y.next * columns + x.first),
        texel(coding, texels, y.next * columns + x.next),
        x.part,
    );
    return mix(low, high, y.part);
}

// The linear colour of a texture, on average over a footprint.
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
    if !(side > 1.0) {
        return lookup_level(image, 0u, place, wrap);
    }
    let depth = log2(side);
    let whole = min(floor(depth), 64.0);
    let fine = lookup_level(image, u32(whole), place, wrap);
    if u32(whole) + 1u >= scene[image + 1u] || depth - whole < 1e-3 {
        return fine;
    }
    return mix(fine, lookup_level(image, u32(whole) + 1u, place, wrap), depth - whole);
}

// The twin of `sampler/mod.rs`: Cook's jittered strata from the CPU's own hashes, bit for bit. Strata are cells of whole
// numbers; only the place within a cell is rounded to a float.

// A 64-bit number, low word first.
alias Wide = vec2<u32>;

const INVERSE_2_32: f32 = 2.3283064365386963e-10;

// The high word of a product.
fn product_high(a: u32, b: u32) -> u32 {
    let low = vec2<u32>(a & 0xffffu, b & 0xffffu);
    let high = vec2<u32>(a >> 16u, b >> 16u);
    let p00 = low.x * low.y;
    let p01 = low.x * high.y;
    let p10 = high.x * low.y;
    let middle = (p00 >> 16u) + (p01 & 0xffffu) + (p10 & 0xffffu);
    return high.x * high.y + (p01 >> 16u) + (p10 >> 16u) + (middle >> 16u);
}

fn wide_product(a: Wide, b: Wide) -> Wide {
    return Wide(a.x * b.x, product_high(a.x, b.x) + a.x * b.y + a.y * b.x);
}

fn wide_sum(a: Wide, b: Wide) -> Wide {
    let low = a.x + b.x;
    return Wide(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// A shift to the right by 1 to 31 bits, added by exclusive or.
fn shifted_in(a: Wide, shift: u32) -> Wide {
    return a ^ Wide((a.x >> shift) | (a.y << (32u - shift)), a.y >> shift);
}

fn hash(key: Wide, value: Wide) -> Wide {
    let factor = Wide(0x7f4a7c15u, 0x9e3779b9u);
    var z = key ^ wide_sum(wide_product(value, factor), Wide(0xf3bcc909u, 0x6a09e667u));
    for (var k = 0; k < 2; k++) {
        z = wide_product(shifted_in(z, 30u), Wide(0x1ce4e5b9u, 0xbf58476du));
        z = wide_product(shifted_in(z, 27u), Wide(0x133111ebu, 0x94d049bbu));
        z = shifted_in(z, 31u);
    }
    return z;
}

// A 32-bit integer as a number in [0, 1).
fn unit(bits: u32) -> f32 {
    return min(f32(bits) * INVERSE_2_32, LARGEST_BELOW_1);
}

// Columns and rows of at least `count` cells: two near factors if there are such.
fn grid_of(count: u32) -> vec2<u32> {
    var most = u32(sqrt(f32(count)));
    while most * most > count {
        most -= 1u;
    }
    while (most + 1u) * (most + 1u) <= count {
        most += 1u;
    }
    // d >= 0.7 root, in whole numbers.
    for (var d = most; f32(d) >= 0.7 * sqrt(f32(count)) - 1e-3; d--) {
        if d > 0u && 100.0 * f32(d) * f32(d) >= 49.0 * f32(count) && count % d == 0u {
            return vec2<u32>(count / d, d);
        }
        if d <= 1u {
            break;
        }
    }
    let columns = select(most, most + 1u, most * most < count);
    return vec2<u32>(columns, (count + columns - 1u) / columns);
}

// The image of a number under the permutation of `count` that a key names.
fn image_of(index: u32, count: u32, key: Wide) -> u32 {
    var bits = 0u;
    if count > 1u {
        bits = 32u - countLeadingZeros(count - 1u);
    }
    let mask = (1u << bits) - 1u;
    let shift = max(bits / 2u, 1u);
    var rounds: array<Wide, 8>;
    for (var k = 0u; k < 8u; k++) {
        rounds[k] = hash(key, Wide(k + 1u, 0u));
    }
    var i = index;
    loop {
        for (var k = 0u; k < 8u; k++) {
            let round = rounds[k];
            i = (i ^ round.x) & mask;
            i = (i * (round.y | 1u)) & mask;
            i = i ^ (i >> shift);
            i = (i + ((round.x >> 24u) | (round.y << 8u))) & mask;
        }
        if i < count {
            break;
        }
    }
    return i;
}

// The jittered point of a cell of a grid.
fn point_in(cell: u32, grid: vec2<u32>, jitter: Wide) -> vec2<f32> {
    let place = vec2<f32>(f32(cell % grid.x), f32(cell / grid.x));
    let within = vec2<f32>(unit(jitter.y), unit(jitter.x));
    return min((place + within) / vec2<f32>(grid), vec2<f32>(LARGEST_BELOW_1));
}

// What a point of the unit square is used for.
const LIGHT: u32 = 1u;
const GLOSS: u32 = 2u;
const BOUNCE: u32 = 3u;

// The point of a strand of the pixel of a key, in [0, 1)^2. `detail` has bounces and light as the CPU has them.
fn strata_point(pixel: Wide, kind: u32, detail: Wide, index: u32, count: u32) -> vec2<f32> {
    let grid = grid_of(max(count, 1u));
    let cells = grid.x * grid.y;
    let key = hash(hash(hash(pixel, Wide(kind, 0u)), detail), Wide(count, 0u));
    let cell = image_of(index % cells, cells, key);
    return point_in(cell, grid, hash(hash(key, Wide(0u, 0u)), Wide(cell, 0u)));
}

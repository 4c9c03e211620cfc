// The twin of `sampler/path.rs`: the numbers of a path, from the CPU's own hashes and scrambles, bit for bit, rounded to
// floats at the end.

struct PathSampler {
    key: Wide,
    sample: u32,
    dimension: u32,
}

const INDEPENDENT: u32 = 1u;

var<private> sampler_now: PathSampler;

fn next_key() -> Wide {
    sampler_now.dimension += 1u;
    return hash(sampler_now.key, Wide(sampler_now.dimension, 0u));
}

// A key of its own for each of a dimension's scrambles.
fn mixed_key(key: Wide, which: u32) -> Wide {
    var z = wide_sum(key, wide_product(Wide(which, 0u), Wide(0x7f4a7c15u, 0x9e3779b9u)));
    z = wide_product(shifted_in(z, 30u), Wide(0x1ce4e5b9u, 0xbf58476du));
    z = wide_product(shifted_in(z, 27u), Wide(0x133111ebu, 0x94d049bbu));
    return shifted_in(z, 31u);
}

fn half_turned(x: u32) -> u32 {
    return (x << 16u) | (x >> 16u);
}

fn scrambled(given: u32, key: Wide) -> u32 {
    var x = given + key.x;
    x ^= x * 0x6c50b47cu;
    x = x * (key.y | 1u);
    x ^= x * 0xb82f1e52u;
    x = x + half_turned(key.y);
    x ^= x * 0xc7afe638u;
    x = x * (half_turned(key.x) | 1u);
    return x ^ (x * 0x8d22f6e6u);
}

// The second Sobol coordinate of an index.
fn second_coordinate(index: u32) -> u32 {
    var v = index;
    v ^= v >> 16u;
    v ^= (v & 0xff00ff00u) >> 8u;
    v ^= (v & 0xf0f0f0f0u) >> 4u;
    v ^= (v & 0xccccccccu) >> 2u;
    return v ^ ((v & 0xaaaaaaaau) >> 1u);
}

fn jittered(key: Wide, grid: vec2<u32>) -> vec2<f32> {
    let cell = image_of(sampler_now.sample, grid.x * grid.y, key);
    return point_in(cell, grid, hash(key, Wide(cell, 0u)));
}

// The next number, in [0, 1).
fn next_one() -> f32 {
    let key = next_key();
    if JITTERED {
        return jittered(key, vec2<u32>(max(now.samples, 1u), 1u)).x;
    }
    if scene[SAMPLER] == INDEPENDENT {
        return unit(key.y);
    }
    let index = reverseBits(scrambled(sampler_now.sample, key));
    return unit(reverseBits(scrambled(index, mixed_key(key, 1u))));
}

// The next pair, in [0, 1)^2.
fn next_two() -> vec2<f32> {
    let key = next_key();
    if JITTERED {
        return jittered(key, grid_of(max(now.samples, 1u)));
    }
    if scene[SAMPLER] == INDEPENDENT {
        return vec2<f32>(unit(key.y), unit(key.x));
    }
    let index = reverseBits(scrambled(sampler_now.sample, key));
    let x = scrambled(index, mixed_key(key, 1u));
    let y = scrambled(second_coordinate(index), mixed_key(key, 2u));
    return vec2<f32>(unit(reverseBits(x)), unit(reverseBits(y)));
}

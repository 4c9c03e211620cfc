// Samples of the map that `task` tells of, as keys: whole numbers in the order of the samples, so that no device can flush,
// fuse or round anything.

// The sample that a line of an axis shows.
fn sample_of(axis: u32, line: u32) -> u32 {
    let count = task.samples[axis];
    if task.padded == 1u {
        return min(max(line, 1u) - 1u, count - 1u);
    }
    return select(0u, line, line < count);
}

// The key of a float by its bits; both zeros have one.
fn key_of_bits(bits: u32) -> u32 {
    if (bits & 0x7fffffffu) == 0u {
        return 0x80000000u;
    }
    return select(bits | 0x80000000u, ~bits, (bits >> 31u) == 1u);
}

// The key of a sample; codes are their own.
fn key_of(i: u32, j: u32) -> u32 {
    let at = j * task.samples.x + i;
    if task.floats == 1u {
        return key_of_bits(height_word(task.heights + at));
    }
    let pair = height_word(task.heights + (at >> 1u));
    return select(pair & 0xffffu, pair >> 16u, (at & 1u) == 1u);
}

// The bits of a key of floats.
fn bits_of(key: u32) -> u32 {
    return select(~key, key & 0x7fffffffu, (key >> 31u) == 1u);
}

// Whole numbers of 64 bits, the low word in `x`.

alias Whole = vec2<u32>;

fn plus(a: Whole, b: Whole) -> Whole {
    let low = a.x + b.x;
    return Whole(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn minus(a: Whole, b: Whole) -> Whole {
    return Whole(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

fn is_less(a: Whole, b: Whole) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

fn least_of(a: Whole, b: Whole) -> Whole {
    return select(a, b, vec2<bool>(is_less(b, a)));
}

fn shifted_left(a: Whole, by: u32) -> Whole {
    if by == 0u {
        return a;
    }
    if by >= 64u {
        return Whole(0u);
    }
    if by >= 32u {
        return Whole(0u, a.x << (by - 32u));
    }
    return Whole(a.x << by, (a.y << by) | (a.x >> (32u - by)));
}

fn shifted_right(a: Whole, by: u32) -> Whole {
    if by == 0u {
        return a;
    }
    if by >= 64u {
        return Whole(0u);
    }
    if by >= 32u {
        return Whole(a.y >> (by - 32u), 0u);
    }
    return Whole((a.x >> by) | (a.y << (32u - by)), a.y >> by);
}

// Zeros above the highest bit.
fn zeros_above(a: Whole) -> u32 {
    if a.y != 0u {
        return countLeadingZeros(a.y);
    }
    return 32u + countLeadingZeros(a.x);
}

// All 64 bits of a product of words.
fn word_product(a: u32, b: u32) -> Whole {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let cross = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let other = (a & 0xffffu) * (b >> 16u) + (cross & 0xffffu);
    return Whole((low & 0xffffu) | (other << 16u), (a >> 16u) * (b >> 16u) + (cross >> 16u) + (other >> 16u));
}

// Numbers of 53 bits, rounded to the nearest as `f64` rounds, ties to even: what the CPU's kind `boxes` computes with before
// it counts in whole numbers. Exponents have no end: nothing vanishes or overflows.

struct Exact {
    negative: bool,
    // The highest bit set is bit 52, or none for 0.
    digits: Whole,
    // The number is digits times 2 to this power.
    power: i32,
}

// A number from its bits as `f64`; one too small for 53 bits counts as 0.
fn exact_of_double(bits: Whole) -> Exact {
    let exponent = i32((bits.y >> 20u) & 0x7ffu);
    if exponent == 0 {
        return Exact(false, Whole(0u), 0);
    }
    return Exact((bits.y >> 31u) == 1u, Whole(bits.x, (bits.y & 0xfffffu) | 0x100000u), exponent - 1075);
}

// A number from its bits as `f32`.
fn exact_of_float(bits: u32) -> Exact {
    let exponent = i32((bits >> 23u) & 0xffu);
    let digits = (bits & 0x7fffffu) | select(0u, 0x800000u, exponent > 0);
    return trimmed((bits >> 31u) == 1u, Whole(digits, 0u), max(exponent, 1) - 150, false);
}

// The number of some digits, rounded; `more` where digits were lost below the lowest.
fn trimmed(negative: bool, digits: Whole, power: i32, more: bool) -> Exact {
    if digits.x == 0u && digits.y == 0u {
        return Exact(false, digits, 0);
    }
    let zeros = zeros_above(digits);
    if zeros >= 11u {
        return Exact(negative, shifted_left(digits, zeros - 11u), power - i32(zeros - 11u));
    }
    let over = 11u - zeros;
    var kept = shifted_right(digits, over);
    let lost = minus(digits, shifted_left(kept, over));
    let half = shifted_left(Whole(1u, 0u), over - 1u);
    let tie = lost.x == half.x && lost.y == half.y && !more;
    if is_less(half, lost) || (lost.x == half.x && lost.y == half.y && more) || (tie && (kept.x & 1u) == 1u) {
        kept = plus(kept, Whole(1u, 0u));
    }
    let carried = (kept.y >> 21u) == 1u;
    return Exact(negative, shifted_right(kept, select(0u, 1u, carried)), power + i32(over) + select(0, 1, carried));
}

fn is_none(a: Exact) -> bool {
    return a.digits.x == 0u && a.digits.y == 0u;
}

fn exact_difference(a: Exact, b: Exact) -> Exact {
    let turned = Exact(!b.negative, b.digits, b.power);
    if is_none(a) {
        return turned;
    }
    if is_none(b) {
        return a;
    }
    var large = a;
    var small = turned;
    if a.power < b.power || (a.power == b.power && is_less(a.digits, b.digits)) {
        large = turned;
        small = a;
    }
    // Ten bits more than are kept: what is shifted out says only that there is something.
    let by = u32(large.power - small.power);
    let whole = shifted_left(small.digits, 10u);
    var shown = shifted_right(whole, by);
    let back = shifted_left(shown, by);
    let more = by >= 64u || back.x != whole.x || back.y != whole.y;
    if large.negative == small.negative {
        let sum = plus(shifted_left(large.digits, 10u), shown);
        return trimmed(large.negative, sum, large.power - 10, more);
    }
    if more {
        // The rest counts from above.
        shown = plus(shown, Whole(1u, 0u));
    }
    return trimmed(large.negative, minus(shifted_left(large.digits, 10u), shown), large.power - 10, more);
}

fn exact_product(a: Exact, b: Exact) -> Exact {
    // 106 bits in four words.
    let low = word_product(a.digits.x, b.digits.x);
    let high = word_product(a.digits.y, b.digits.y);
    let first = word_product(a.digits.x, b.digits.y);
    let second = word_product(a.digits.y, b.digits.x);
    // Neither cross product has more than 53 bits.
    let middle = plus(plus(first, second), Whole(low.y, 0u));
    let top = plus(high, Whole(middle.y, 0u));
    // The upper 64 of them, and whether there is something below.
    let digits = plus(shifted_left(top, 22u), Whole(middle.x >> 10u, 0u));
    let more = low.x != 0u || (middle.x & 0x3ffu) != 0u;
    return trimmed(a.negative != b.negative, digits, a.power + b.power + 42, more);
}

// The largest whole number not above one that is at least 0 and below 2^63.
fn whole_part(a: Exact) -> Whole {
    if a.power >= 0 {
        return shifted_left(a.digits, u32(a.power));
    }
    return shifted_right(a.digits, u32(-a.power));
}

// The twin of `relief/sphere/clip.rs` in doubles: the parts of a ray between the two balls that hold the
// surface.

const ROOF: u32 = 0u;
const FLOOR: u32 = 1u;
const ORIGIN: u32 = 2u;

struct SpherePart {
    start: array<Double, 3>,
    direction: array<Double, 3>,
    // The ray's parameter at the start, and how far the part goes on from there.
    t: Double,
    length: Double,
    // Where the line is closest to the centre, from the start.
    nearest: Double,
    // ROOF, FLOOR or ORIGIN.
    begins: u32,
}

// A ray relative to the centre, moved near, and where it is between the balls.
struct Chords {
    origin: array<Double, 3>,
    direction: array<Double, 3>,
    moved: Double,
    middle: Double,
    // Half the chords in the outer and in the inner ball; negative where there is none.
    outer: Double,
    inner: Double,
}

// Half the chord in a ball of a line that comes as near to the centre as the root of `distance`, or a
// negative number.
fn half_chord(radius: Double, distance: Double, per_length: Double) -> Double {
    let square = difference(product(radius, radius), distance);
    if square.x < 0.0 {
        return double(-1.0);
    }
    return root(product(square, per_length));
}

fn chords_of(origin: array<Double, 3>, direction: array<Double, 3>) -> Chords {
    var c: Chords;
    c.origin = origin;
    c.direction = direction;
    let per_length = ratio(double(1.0), dot_double(direction, direction));
    let wide = scaled(radii.outer, 1.5);
    var far = below(product(wide, wide), dot_double(origin, origin));
    loop {
        c.middle = -product(dot_double(c.origin, direction), per_length);
        var near: array<Double, 3>;
        for (var k = 0u; k < 3u; k++) {
            near[k] = sum(c.origin[k], product(c.middle, direction[k]));
        }
        let distance = dot_double(near, near);
        var ball = radii.outer;
        if far {
            ball = wide;
        }
        c.outer = half_chord(ball, distance, per_length);
        if !far || c.outer.x < 0.0 {
            c.inner = half_chord(radii.inner, distance, per_length);
            return c;
        }
        far = false;
        c.moved = larger_double(difference(c.middle, c.outer), double(0.0));
        for (var k = 0u; k < 3u; k++) {
            c.origin[k] = sum(c.origin[k], product(c.moved, direction[k]));
        }
    }
    return c;
}

// The first or the second part; its length is negative where there is none.
fn sphere_part(c: Chords, second: bool) -> SpherePart {
    var part: SpherePart;
    part.length = double(-1.0);
    if c.outer.x < 0.0 || (second && c.inner.x < 0.0) {
        return part;
    }
    var from_ = difference(c.middle, c.outer);
    var to = sum(c.middle, c.outer);
    part.begins = ROOF;
    if second {
        from_ = sum(c.middle, c.inner);
        part.begins = FLOOR;
    } else if c.inner.x >= 0.0 {
        to = difference(c.middle, c.inner);
    }
    if from_.x <= 0.0 {
        from_ = double(0.0);
        part.begins = ORIGIN;
    }
    for (var k = 0u; k < 3u; k++) {
        part.start[k] = sum(c.origin[k], product(from_, c.direction[k]));
    }
    part.direction = c.direction;
    part.t = sum(c.moved, from_);
    part.length = difference(to, from_);
    part.nearest = difference(c.middle, from_);
    return part;
}

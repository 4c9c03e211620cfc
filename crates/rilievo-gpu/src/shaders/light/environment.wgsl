// The twin of `light/environment/mod.rs` and `light/distribution.rs`: an image of the sky.

struct SkySeen {
    radiance: vec3<f32>,
    // Density with which the direction is drawn, per steradian.
    pdf: f32,
}

fn sky_axis(k: u32) -> vec3<f32> {
    return triple(scene[SKY] + 9u + 3u * k);
}

fn sky_texel(column: u32, row: u32) -> vec3<f32> {
    return triple(scene[scene[SKY] + 2u] + 3u * (row * scene[scene[SKY]] + column));
}

// The texels around a place of the image, mixed.
fn sky_mixed(at: vec2<f32>) -> vec3<f32> {
    let width = scene[scene[SKY]];
    let height = scene[scene[SKY] + 1u];
    let x = at.x * f32(width) - 0.5;
    let y = clamp(at.y * f32(height) - 0.5, 0.0, f32(height - 1u));
    let left = floor(x);
    let low = floor(y);
    let i = select(min(u32(max(left, 0.0)), width - 1u), width - 1u, left < 0.0);
    let next = select(i + 1u, 0u, i + 1u == width);
    let j = u32(low);
    let above = min(j + 1u, height - 1u);
    let part = vec2<f32>(x - left, y - low);
    var mixed = vec3<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        let far = vec2<bool>((k & 1u) == 1u, k > 1u);
        let weights = select(1.0 - part, part, far);
        mixed += weights.x * weights.y * sky_texel(select(i, next, far.x), select(j, above, far.y));
    }
    return mixed;
}

// The place of a unit direction in the image.
fn sky_place(direction: vec3<f32>) -> vec2<f32> {
    let d = vec3<f32>(
        dot(direction, sky_axis(0u)),
        dot(direction, sky_axis(1u)),
        dot(direction, sky_axis(2u)),
    );
    let turn = clamp(0.5 - angle_of(d.xy) / (2.0 * PI), 0.0, 1.0);
    return vec2<f32>(turn, 1.0 - angle_of(vec2<f32>(d.z, length(d.xy))) / PI);
}

fn sky_rows() -> u32 {
    return scene[scene[SKY] + 5u];
}

// Solid angle of a cell of the grid that directions are drawn from.
fn sky_solid_angle(cell: vec2<u32>) -> f32 {
    let width = scene[scene[SKY]];
    let side = scene[scene[SKY] + 3u];
    let columns = min((cell.x + 1u) * side, width) - cell.x * side;
    let height = number(scene[scene[SKY] + 6u] + 2u * cell.y + 1u);
    return 2.0 * PI * (f32(columns) / f32(width)) * height;
}

fn sky_share(cell: vec2<u32>) -> f32 {
    let rows = scene[scene[SKY] + 7u] + cell.y;
    let row = scene[scene[SKY] + 8u] + cell.y * (scene[scene[SKY] + 4u] + 1u) + cell.x;
    return (number(rows + 1u) - number(rows)) * (number(row + 1u) - number(row));
}

fn sky_seen(direction: vec3<f32>) -> SkySeen {
    let at = sky_place(direction);
    if sky_rows() == 0u {
        return SkySeen(vec3<f32>(0.0), 0.0);
    }
    let size = vec2<u32>(scene[scene[SKY]], scene[scene[SKY] + 1u]);
    let texel_at = min(vec2<u32>(at * vec2<f32>(size)), size - 1u);
    let cell = texel_at / scene[scene[SKY] + 3u];
    return SkySeen(sky_mixed(at), sky_share(cell) / sky_solid_angle(cell));
}

// The part of `count` sums from a place on in which u falls, and the place in it.
struct Inverted {
    part: u32,
    within: f32,
    share: f32,
}

fn inverted(sums: u32, count: u32, u: f32) -> Inverted {
    // The sums before `low` are at most u, those from `high` on above.
    var low = 1u;
    var high = count;
    while low < high {
        let middle = (low + high) / 2u;
        if number(sums + middle) <= u {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    let below_u = number(sums + low - 1u);
    let share = number(sums + low) - below_u;
    return Inverted(low - 1u, clamp((u - below_u) / share, 0.0, 1.0), share);
}

fn sample_sky(u: vec2<f32>) -> LightSample {
    var sample: LightSample;
    if sky_rows() == 0u {
        return sample;
    }
    let width = scene[scene[SKY]];
    let columns = scene[scene[SKY] + 4u];
    let row = inverted(scene[scene[SKY] + 7u], sky_rows(), u.y);
    let cells = scene[scene[SKY] + 8u] + row.part * (columns + 1u);
    let column = inverted(cells, columns, u.x);
    let side = scene[scene[SKY] + 3u];
    let first = column.part * side;
    let last = min(first + side, width);
    let along = (f32(first) + column.within * f32(last - first)) / f32(width);
    let edges = scene[scene[SKY] + 6u] + 2u * row.part;
    let height = number(edges) + row.within * number(edges + 1u);
    let turn = sin_cos_turns(along - 0.5);
    let level = sqrt(max((1.0 - height) * (1.0 + height), 0.0));
    let local = vec3<f32>(level * turn.y, -level * turn.x, height);
    sample.direction = normalize(local.x * sky_axis(0u) + local.y * sky_axis(1u) + local.z * sky_axis(2u));
    let latitude = 1.0 - angle_of(vec2<f32>(height, level)) / PI;
    sample.pdf = row.share * column.share / sky_solid_angle(vec2<u32>(column.part, row.part));
    sample.weight = sky_mixed(vec2<f32>(along, latitude)) / sample.pdf;
    sample.valid = sample.pdf > 0.0;
    let way = sample.direction;
    sample.way = Place3(double(way.x), double(way.y), double(way.z));
    sample.end = double(ENDLESS);
    return sample;
}

// Radiance that comes against a unit direction where nothing is met, without suns.
fn sky_and_background(direction: vec3<f32>) -> vec3<f32> {
    var radiance = triple(BACKGROUND);
    if HAS_SKY {
        radiance += sky_mixed(sky_place(direction));
    }
    return radiance;
}

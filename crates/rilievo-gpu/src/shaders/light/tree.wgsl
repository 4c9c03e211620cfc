// The twin of `light/tree.rs` and `light/bounds.rs`: which of many lights to sample, and how probable that was.

// The point that light is sampled for.
struct Receiver {
    position: Place3,
    // Unit, on the side the viewer is on.
    normal: vec3<f32>,
    both_sides: bool,
}

const ROUNDING: f32 = 1e-6;
const BESIDE: f32 = 0.1;

// Cosine and sine of the first angle less the second, of 0 if that is larger.
fn less_angle(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    if a.x > b.x {
        return vec2<f32>(1.0, 0.0);
    }
    return vec2<f32>(a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y);
}

// Where the nodes of the tree at hand lie.
var<private> nodes_now: u32;

fn tree_node(index: u32) -> u32 {
    return nodes_now + TREE_RECORD * index;
}

// What the intensity of a node brings, a part of it at most `most`, for a factor on both.
fn held_at(node: u32, factor: f32, most: f32) -> f32 {
    let held = number(node + 16u);
    let free = (number(node + 12u) - held) * factor;
    return select(free, free + min(held * factor, most), held > 0.0);
}

// An estimate of what the lights below a node bring to a receiver.
fn importance(index: u32, at: Receiver) -> f32 {
    let node = tree_node(index);
    let half = triple(node + 6u);
    let way = way_between(place_in_scene(node), at.position);
    let squared = dot(way, way);
    let radius_squared = dot(half, half);
    let reach = max(max(squared, 0.1 * radius_squared), 1e-37);
    if squared <= radius_squared {
        return held_at(node, 1.0 / reach, BESIDE * number(node + 17u));
    }
    let towards = way / sqrt(squared);
    let sin2_box = radius_squared / squared;
    let of_box = vec2<f32>(sqrt(max(1.0 - sin2_box, 0.0)), sqrt(sin2_box));
    let axis = triple(node + 9u);
    // The sine by the cross product, which does not cancel.
    let of_axis = vec2<f32>(dot(axis, towards), length(cross(axis, towards)));
    let of_normals = vec2<f32>(number(node + 13u), number(node + 14u));
    let outwards = less_angle(less_angle(of_axis, of_normals), of_box).x;
    if outwards <= number(node + 15u) - ROUNDING {
        return 0.0;
    }
    let brought = held_at(node, max(outwards, ROUNDING) / reach, number(node + 17u));
    var inwards = -dot(towards, at.normal);
    inwards = select(inwards, abs(inwards), at.both_sides);
    let of_receiver = vec2<f32>(inwards, length(cross(towards, at.normal)));
    let cos_in = less_angle(of_receiver, of_box).x;
    if cos_in <= -ROUNDING {
        return 0.0;
    }
    return brought * max(cos_in, ROUNDING);
}

// The probability of the first child of an inner node; negative where neither reaches.
fn first_share(index: u32, at: Receiver) -> f32 {
    var each: array<f32, 2>;
    for (var k = 0u; k < 2u; k++) {
        each[k] = importance(select(index + 1u, scene[tree_node(index) + 18u], k == 1u), at);
    }
    let first = each[0];
    let both = first + each[1];
    if !(both < ENDLESS) {
        return 0.5;
    }
    return select(-1.0, first / both, both > 0.0);
}

struct Chosen {
    light: u32,
    probability: f32,
    // A number for what is chosen next.
    rest: f32,
}

// A light for u in [0, 1); of probability 0 where no light reaches the receiver.
fn choose_light(at: Receiver, choice: f32) -> Chosen {
    var u = choice;
    var index = 0u;
    var probability = 1.0;
    for (var steps_down = 0u; steps_down < 70u; steps_down++) {
        let node = tree_node(index);
        if scene[node + 19u] != 0u {
            return Chosen(scene[node + 18u], probability, u);
        }
        let share = first_share(index, at);
        if share < 0.0 {
            break;
        }
        if u < share {
            u = min(u / share, LARGEST_BELOW_1);
            probability *= share;
            index += 1u;
        } else {
            u = clamp((u - share) / (1.0 - share), 0.0, LARGEST_BELOW_1);
            probability *= 1.0 - share;
            index = scene[node + 18u];
        }
    }
    return Chosen(0u, 0.0, u);
}

// The probability of `choose_light` for a light, whose way through the tree is one of those from a place on.
fn light_probability(at: Receiver, ways: u32, light: u32) -> f32 {
    var way = vec2<u32>(scene[ways + 2u * light], scene[ways + 2u * light + 1u]);
    if all(way == vec2<u32>(NOTHING)) {
        return 0.0;
    }
    var index = 0u;
    var probability = 1.0;
    for (var steps_down = 0u; steps_down < 70u; steps_down++) {
        let node = tree_node(index);
        if scene[node + 19u] != 0u {
            return probability;
        }
        let share = first_share(index, at);
        if share < 0.0 {
            break;
        }
        if (way.x & 1u) == 0u {
            probability *= share;
            index += 1u;
        } else {
            probability *= 1.0 - share;
            index = scene[node + 18u];
        }
        way = vec2<u32>((way.x >> 1u) | (way.y << 31u), way.y >> 1u);
    }
    return 0.0;
}

// The twin of `integrator/path`: one path a camera ray, a step at a time. Every slot has two rays out at most: that of the
// path, and behind those of all slots the one to the light that was drawn before. A step takes in what both met.

// A path on its way.
struct Walk {
    throughput: vec3<f32>,
    depth: u32,
    // Length of the way to where the ray starts.
    distance: f32,
    // How the ray in hand was scattered: its density, negative where nothing but the ray itself could find what it
    // meets; and from where.
    pdf: f32,
    both_sides: u32,
    // What ray to a light is out: NO_LIGHT or one of those after it.
    asks: u32,
    position: Place3,
    // The emitter that it is aimed at, and the density with which the material finds that direction.
    aimed: u32,
    aim_pdf: f32,
    normal: vec3<f32>,
    // What that ray brings if nothing is in its way; of one that is aimed, a factor on what it meets.
    brought: vec3<f32>,
}

struct Trees {
    // Slots whose paths are whole.
    done: atomic<u32>,
    of_slots: array<Walk>,
}

// It counts if it meets nothing, or what it is aimed at, or the very point of that.
const NO_LIGHT: u32 = 0u;
const FREE: u32 = 1u;
const AIMED: u32 = 2u;
const AIMED_EXACTLY: u32 = 3u;

// What is out.
const CAMERA: u32 = 0u;
const GOES_ON: u32 = 1u;
const ENDS: u32 = 2u;
const DONE: u32 = 3u;

// Bounces before Russian roulette begins, and the least probability with which it ends a path.
const SAFE: u32 = 2u;
const LEAST_END: f32 = 0.05;

fn add_radiance(at: u32, radiance: vec3<f32>) {
    for (var k = 0u; k < 3u; k++) {
        slots[at].radiance[k] += radiance[k];
    }
}

// The power heuristic.
fn power(own: f32, other: f32) -> f32 {
    let r = min(other / own, 1e18);
    return 1.0 / (1.0 + r * r);
}

// What a bounce brings, no more than is allowed.
fn held(brought: vec3<f32>, bounces: u32) -> vec3<f32> {
    let largest = largest_of(brought);
    let limit = number(CLAMP_AT);
    return select(brought * (limit / largest), brought, bounces <= 1u || largest <= limit);
}

fn weight_of(walk: Walk, sampled: f32) -> f32 {
    return select(power(walk.pdf, sampled), 1.0, walk.pdf < 0.0);
}

// Radiance that comes against a ray that meets nothing.
fn escaped(walk: Walk, direction: vec3<f32>) -> vec3<f32> {
    var radiance = triple(BACKGROUND);
    let groups = f32(max(scene[GROUPS], 1u));
    for (var k = 0u; k < scene[SUNS]; k++) {
        let sun = scene[FIRST_SUN] + LIGHT_RECORD * k;
        if sees_sun(sun, direction) {
            radiance += triple(sun + 4u) * weight_of(walk, cone_pdf(number(sun + 3u)) / groups);
        }
    }
    if HAS_SKY {
        let seen = sky_seen(direction);
        radiance += seen.radiance * weight_of(walk, seen.pdf / groups);
    }
    return radiance;
}

// Whether a ray that was aimed at an emitter met that.
fn finds(walk: Walk, asks: u32, hit: Hit, source: Ray) -> bool {
    let whole = hit.t.x * (1.0 + SAME) >= source.t_max.x * (1.0 - SAME);
    let front = (hit.part & FRONT) != 0u;
    return hit.surface == walk.aimed && front && (asks == AIMED || whole);
}

// Takes in what the rays that were out met, that to an emitter first, and scatters the path's own; false at its end.
fn take_step(at: u32, walk_of: ptr<function, Walk>, asks: u32, ended: bool) -> bool {
    let depth = (*walk_of).depth;
    var point: Point;
    var bsdf: Bsdf;
    var direction: vec3<f32>;
    var first = 1u;
    if EMITTERS {
        first = select(1u, 0u, asks > FREE);
    }
    for (var k = first; k < select(2u, 1u, ended); k++) {
        let aimed = EMITTERS && k == 0u;
        let place = select(at, now.slots + at, aimed);
        let hit = hits[place];
        let source = rays[place];
        direction = normalize(rough_direction(source));
        if aimed && !finds(*walk_of, asks, hit, source) {
            continue;
        }
        if hit.surface == NOTHING {
            add_radiance(at, held((*walk_of).throughput * escaped(*walk_of, direction), depth));
            return false;
        }
        point = point_of(hit, source);
        if !aimed {
            (*walk_of).distance += point.distance;
        }
        let width = number(SPREAD) * (*walk_of).distance;
        let lengths = vec2<f32>(length(point.along_u), length(point.along_v));
        let over = select(vec2<f32>(0.0), width / max(lengths, vec2<f32>(1e-37)), lengths > vec2<f32>(0.0));
        let ends = aimed || depth > scene[MAX_DEPTH];
        bsdf = bsdf_of(material_of(hit.surface), point, -direction, Footprint(point.uv, over), ends);
        if point.front && !is_black(bsdf.emitted) {
            var factor = (*walk_of).throughput;
            if aimed || (*walk_of).pdf >= 0.0 {
                let before = Receiver((*walk_of).position, (*walk_of).normal, (*walk_of).both_sides != 0u);
                let sampled = pdf_of_hit(before, direction, point);
                if aimed {
                    let weight = power(sampled, (*walk_of).aim_pdf) / sampled;
                    factor = select(vec3<f32>(0.0), (*walk_of).brought * weight, sampled > 0.0);
                } else {
                    factor *= power((*walk_of).pdf, sampled);
                }
            }
            add_radiance(at, held(factor * bsdf.emitted, depth));
        }
        if ends && !aimed {
            return false;
        }
    }
    if ended {
        return false;
    }
    let facing = select(-point.geometric, point.geometric, point.front);
    let receiver = Receiver(point.position, facing, bsdf_transmits(&bsdf));
    // Drawn whether or not they are used, so that every bounce has dimensions of its own.
    var choice = 0.0;
    if scene[CHOOSES] != 0u {
        choice = next_one();
    }
    let place_of_light = next_two();
    let lobe = next_one();
    let place = next_two();
    var drawn: DrawnLight;
    if !bsdf_is_delta(&bsdf) {
        drawn = draw_light(receiver, choice, place_of_light);
        drawn.sample.valid = drawn.sample.valid && drawn.surface != point.surface;
    }
    var scattered = sample_bsdf(&bsdf, lobe, place);
    // What the material says of the light that was drawn, and of the way that the path goes on.
    var values: array<vec4<f32>, 2>;
    let asked = array<bool, 2>(drawn.sample.valid, scattered.found && !scattered.delta);
    for (var k = 0u; k < 2u; k++) {
        if asked[k] {
            let light = select(drawn.sample.direction, scattered.direction, k == 1u);
            values[k] = evaluate_bsdf(&bsdf, light);
        }
    }
    let value = values[0];
    if !is_black(value.xyz) {
        var weight = 1.0;
        if drawn.sample.pdf > 0.0 {
            weight = power(drawn.sample.pdf, value.w);
        }
        let brought = (*walk_of).throughput * value.xyz;
        (*walk_of).brought = held(brought * drawn.sample.weight * weight, depth + 1u);
        (*walk_of).asks = FREE;
        var shadow = spawn(point, drawn.sample.way, drawn.sample.end);
        shadow.exempt = drawn.exempt;
        shadow.any = 1u;
        if EMITTERS {
            if drawn.aimed != NOTHING {
                (*walk_of).brought = brought;
                (*walk_of).asks = select(AIMED, AIMED_EXACTLY, drawn.exact);
                (*walk_of).aimed = drawn.aimed;
                (*walk_of).aim_pdf = value.w;
                shadow.any = 0u;
            }
        }
        rays[now.slots + at] = shadow;
        slots[at].sent[0] += 1u;
    }
    (*walk_of).position = point.position;
    (*walk_of).normal = facing;
    (*walk_of).both_sides = u32(receiver.both_sides);
    (*walk_of).depth = depth + 1u;
    scattered = weighed(scattered, values[1]);
    if !scattered.found {
        return false;
    }
    (*walk_of).throughput *= scattered.weight;
    if depth >= SAFE {
        let go_on = min(largest_of((*walk_of).throughput), 1.0 - LEAST_END);
        if next_one() >= go_on {
            return false;
        }
        (*walk_of).throughput /= go_on;
    }
    (*walk_of).pdf = select(scattered.pdf, -1.0, scattered.delta);
    if scattered.roughness < 1.0 {
        slots[at].sent[1] += 1u;
    } else {
        slots[at].sent[2] += 1u;
    }
    rays[at] = spawn_along(point, scattered.direction);
    return true;
}

@compute @workgroup_size(64)
fn advance(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = now.first + id.x;
    if at >= now.end || slots[at].stage == DONE {
        return;
    }
    zero = rays[at].zero;
    time_now = rays[at].time;
    var walk_now: Walk;
    if slots[at].stage == CAMERA {
        walk_now.throughput = vec3<f32>(1.0);
        walk_now.pdf = -1.0;
    } else {
        walk_now = trees.of_slots[at];
    }
    let asks = walk_now.asks;
    if asks == FREE && hits[now.slots + at].surface == NOTHING {
        add_radiance(at, walk_now.brought);
    }
    walk_now.asks = NO_LIGHT;
    sampler_now = PathSampler(slots[at].key, slots[at].sample, slots[at].dimension);
    var goes_on = false;
    let ended = slots[at].stage == ENDS;
    if !ended || asks > FREE {
        goes_on = take_step(at, &walk_now, asks, ended);
    }
    slots[at].dimension = sampler_now.dimension;
    if walk_now.asks == NO_LIGHT {
        rays[now.slots + at] = no_ray();
    }
    if goes_on {
        slots[at].stage = GOES_ON;
    } else {
        rays[at] = no_ray();
        slots[at].stage = ENDS;
        if walk_now.asks == NO_LIGHT {
            slots[at].stage = DONE;
            atomicAdd(&trees.done, 1u);
        }
    }
    trees.of_slots[at] = walk_now;
}

// The twin of `integrator/distributed.rs` and `integrator/aov.rs`: Whitted's recursion with Cook's samples, one step at a
// time. Every slot holds the tree of a camera ray and has one ray out; a step takes in what it met and sends the next
// one: a shadow ray of the point at hand, or the next branch of the last point that has any left. So a step is a small
// shader, and each tree is added up in its own order, whatever else is on the way. How many `POINTS` wait at once is
// written by `shaders.rs`.

// A ray's place in the tree.
struct Strand {
    throughput: vec3<f32>,
    index: u32,
    count: u32,
    depth: u32,
    // Whether the last bounce was diffuse: the light of lights is counted then.
    lit: u32,
}

// A point whose light is being gathered; what of `Point` it needs.
struct Gathering {
    position: Place3,
    // Towards the front.
    outward: vec3<f32>,
    // On the viewer's side.
    geometric: vec3<f32>,
    shading: vec3<f32>,
    // Towards the viewer.
    view: vec3<f32>,
    diffuse: vec3<f32>,
    strand: Strand,
    surface: u32,
    wall: u32,
    line: i32,
    material: u32,
    reflections: u32,
    bounces: u32,
    // Branches that have been sent.
    sent: u32,
}

// The tree of a camera ray.
struct Tree {
    // Of the ray that is out.
    strand: Strand,
    // What the shadow ray that is out brings if nothing is in its way.
    brought: vec3<f32>,
    // Shadow rays of the last point: all, and those that were chosen.
    shadows: u32,
    chosen: u32,
    // Points.
    size: u32,
    points: array<Gathering, POINTS>,
}

struct Trees {
    // Slots whose trees are whole.
    done: atomic<u32>,
    of_slots: array<Tree>,
}

// What is out.
const CAMERA: u32 = 0u;
const SHADOW: u32 = 1u;
const BRANCH: u32 = 2u;
const DONE: u32 = 3u;

const FIRST_HITS: u32 = 0u;

fn add_radiance(at: u32, radiance: vec3<f32>) {
    for (var k = 0u; k < 3u; k++) {
        slots[at].radiance[k] += radiance[k];
    }
}

fn spawn_from(here: Gathering, direction: Place3, end: Double) -> Ray {
    var point: Point;
    point.position = here.position;
    point.geometric = here.outward;
    point.surface = here.surface;
    point.wall = here.wall;
    point.line = here.line;
    return spawn(point, direction, end);
}

// What is at a hit: how the path goes on from there. The inputs of its material are those at hand.
fn arrive(point: Point, source: Ray, strand: Strand) -> Gathering {
    var here: Gathering;
    let sign = select(-1.0, 1.0, point.front);
    here.strand = strand;
    here.position = point.position;
    here.outward = point.geometric;
    here.geometric = sign * point.geometric;
    here.shading = sign * point.shading;
    here.surface = point.surface;
    here.wall = point.wall;
    here.line = point.line;
    here.view = -normalize(rough_direction(source));
    here.material = material_of(point.surface);
    here.diffuse = inputs[DULL];
    if strand.depth < scene[MAX_DEPTH] {
        let first = strand.depth == 0u;
        if !is_black(reflective_of(here.material)) {
            let glossy = first && alpha_of(here.material) > 0.0;
            here.reflections = select(1u, scene[GLOSSY_SAMPLES], glossy);
        }
        if !is_black(here.diffuse) {
            let many = scene[DIFFUSE_SAMPLES];
            here.bounces = select(min(many, 1u), many, first);
        }
    }
    return here;
}

// Radiance against a ray that meets nothing. Suns are lights: to a diffuse bounce they bring nothing.
fn escaped(direction: vec3<f32>, lit: bool) -> vec3<f32> {
    var radiance = sky_and_background(direction);
    for (var k = 0u; k < scene[SUNS] && !lit; k++) {
        let sun = scene[FIRST_SUN] + LIGHT_RECORD * k;
        if sees_sun(sun, direction) {
            radiance += triple(sun + 4u);
        }
    }
    return radiance;
}

// Sends branch `k` of a point; false where it brings nothing.
fn send_branch(at: u32, here: Gathering, k: u32) -> bool {
    let total = here.reflections + here.bounces;
    var strand = here.strand;
    strand.index = here.strand.index * total + k;
    strand.count = here.strand.count * total;
    strand.depth += 1u;
    let reflects = k < here.reflections;
    strand.lit = select(1u, 0u, reflects);
    let many = select(here.bounces, here.reflections, reflects);
    let branch = select(k - here.reflections, k, reflects);
    let kind = select(BOUNCE, GLOSS, reflects);
    let alpha = alpha_of(here.material);
    var u = vec2<f32>(0.0);
    if !reflects || alpha > 0.0 {
        let depth = Wide(here.strand.depth, 0u);
        let index = here.strand.index * many + branch;
        u = strata_point(slots[at].key, kind, depth, index, here.strand.count * many);
    }
    var direction: vec3<f32>;
    if reflects {
        let normal = visible_normal(here.geometric, here.shading, here.view);
        var facet = normal;
        if alpha > 0.0 {
            let upright = max(dot(here.view, normal), 0.0);
            let along = vec2<f32>(dot(here.view, right_of(normal)), dot(here.view, up_of(normal)));
            facet = around(normal, square_to_visible_normal(u, vec3<f32>(along, upright), alpha));
        }
        direction = 2.0 * dot(here.view, facet) * facet - here.view;
        let height = dot(direction, here.geometric);
        direction -= select(0.0, 2.0 * height, height < 0.0) * here.geometric;
        strand.throughput *= reflective_of(here.material) / f32(many);
        slots[at].sent[1] += 1u;
    } else {
        direction = around(here.shading, square_to_hemisphere(u));
        if dot(direction, here.geometric) <= 0.0 {
            return false;
        }
        strand.throughput *= here.diffuse / f32(many);
        slots[at].sent[2] += 1u;
    }
    let wide = Place3(double(direction.x), double(direction.y), double(direction.z));
    rays[at] = spawn_from(here, wide, double(ENDLESS));
    trees.of_slots[at].strand = strand;
    slots[at].stage = BRANCH;
    return true;
}

// Sends the next shadow ray of the last point that can bring anything; false if there is none left.
fn send_shadow(at: u32) -> bool {
    let all = trees.of_slots[at].shadows;
    var chosen = trees.of_slots[at].chosen;
    if chosen >= all {
        return false;
    }
    let here = trees.of_slots[at].points[trees.of_slots[at].size - 1u];
    let per_light = scene[SHADOW_SAMPLES];
    var sent = false;
    var view: LightView;
    var viewed = NOTHING;
    while chosen < all && !sent {
        let number_of_light = chosen / per_light;
        let light = scene[FIRST_LIGHT] + LIGHT_RECORD * number_of_light;
        let k = chosen % per_light;
        if viewed != number_of_light {
            view = view_of(light, here.position);
            // A flat quad or a sphere cannot light itself.
            view.visible = view.visible && scene[light + LIGHT_SURFACE] != here.surface;
            viewed = number_of_light;
        }
        if !view.visible {
            chosen += per_light - k;
            continue;
        }
        chosen += 1u;
        let detail = Wide(number_of_light, here.strand.depth);
        let of_strand = here.strand.index * per_light + k;
        let u = strata_point(slots[at].key, LIGHT, detail, of_strand, here.strand.count * per_light);
        let sample = sample_light(light, here.position, view, u);
        let cosine = dot(sample.direction, here.shading);
        if !sample.valid || cosine <= 0.0 || dot(sample.direction, here.geometric) <= 0.0 {
            continue;
        }
        sent = true;
        var source = spawn_from(here, sample.way, sample.end);
        source.exempt = exempt_of(light);
        source.any = 1u;
        rays[at] = source;
        trees.of_slots[at].brought = here.strand.throughput * here.diffuse * sample.weight
            * (cosine / (PI * f32(per_light)));
        slots[at].sent[0] += 1u;
        slots[at].stage = SHADOW;
    }
    trees.of_slots[at].chosen = chosen;
    return sent;
}

// Takes in what the ray of a slot met.
fn take_in(at: u32, hit: Hit) {
    let stage = slots[at].stage;
    if stage == SHADOW {
        if hit.surface == NOTHING {
            add_radiance(at, trees.of_slots[at].brought);
        }
        return;
    }
    if stage == CAMERA {
        trees.of_slots[at].strand = Strand(vec3<f32>(1.0), slots[at].sample, now.samples, 0u, 0u);
        trees.of_slots[at].size = 0u;
    }
    let strand = trees.of_slots[at].strand;
    trees.of_slots[at].shadows = 0u;
    trees.of_slots[at].chosen = 0u;
    let source = rays[at];
    let direction = normalize(rough_direction(source));
    let first_hits = scene[INTEGRATOR] == FIRST_HITS;
    if hit.surface == NOTHING {
        add_radiance(at, strand.throughput * escaped(direction, strand.lit != 0u || first_hits));
        return;
    }
    let point = point_of(hit, source);
    let material = material_of(hit.surface);
    read_inputs(material, EMITTED + 1u, Footprint(point.uv, vec2<f32>(0.0)));
    if first_hits {
        let albedo = inputs[DULL] + reflective_of(material);
        add_radiance(at, albedo * abs(dot(point.shading, direction)));
        return;
    }
    let here = arrive(point, source, strand);
    var radiance = here.diffuse * triple(AMBIENT);
    if point.front && !(strand.lit != 0u && is_light(hit.surface)) {
        radiance += inputs[EMITTED];
    }
    add_radiance(at, strand.throughput * radiance);
    if !is_black(here.diffuse) {
        trees.of_slots[at].shadows = scene[LIGHTS] * scene[SHADOW_SAMPLES];
    }
    let size = trees.of_slots[at].size;
    trees.of_slots[at].points[min(size, POINTS - 1u)] = here;
    trees.of_slots[at].size = min(size + 1u, POINTS);
}

// Sends the next ray of a slot; false at the end of its tree.
fn send(at: u32) -> bool {
    if send_shadow(at) {
        return true;
    }
    var found = false;
    while trees.of_slots[at].size > 0u && !found {
        let size = trees.of_slots[at].size;
        let here = trees.of_slots[at].points[size - 1u];
        let total = here.reflections + here.bounces;
        // A point is left with its last branch, so that what does not split needs no room.
        if here.sent + 1u >= total {
            trees.of_slots[at].size = size - 1u;
        } else {
            trees.of_slots[at].points[size - 1u].sent = here.sent + 1u;
        }
        found = here.sent < total && send_branch(at, here, here.sent);
    }
    return found;
}

@compute @workgroup_size(64)
fn advance(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = now.first + id.x;
    if at >= now.end || slots[at].stage == DONE {
        return;
    }
    zero = rays[at].zero;
    time_now = rays[at].time;
    take_in(at, hits[at]);
    if !send(at) {
        slots[at].stage = DONE;
        rays[at] = no_ray();
        atomicAdd(&trees.done, 1u);
    }
}

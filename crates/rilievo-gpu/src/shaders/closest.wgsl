// The nearest hit of every ray of a dispatch; of one that asks for no more, any hit, or only whether there is one.

fn store_double(word: u32, x: Double) {
    hits[word] = bitcast<u32>(x.x);
    hits[word + 1u] = bitcast<u32>(x.y);
}

// Writes a hit word by word, in the order of its fields.
fn store_hit(at: u32, hit: Hit) {
    let word = 12u * at;
    store_double(word, hit.t);
    store_double(word + 2u, hit.local[0]);
    store_double(word + 4u, hit.local[1]);
    hits[word + 6u] = bitcast<u32>(hit.cell.x);
    hits[word + 7u] = bitcast<u32>(hit.cell.y);
    hits[word + 8u] = hit.surface;
    hits[word + 9u] = hit.part;
    hits[word + 10u] = hit.steps;
    hits[word + 11u] = hit.piece;
}

@compute @workgroup_size(64)
fn closest(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = params.first + id.x;
    if at >= params.end {
        return;
    }
    zero = rays[at].zero;
    ignored = rays[at].exempt;
    steps = 0u;
    var hit = nearest(rays[at]);
    if params.whether == 1u {
        hits[at] = select(1u, 0u, hit.surface == NOTHING);
        return;
    }
    hit.steps = steps;
    store_hit(at, hit);
}

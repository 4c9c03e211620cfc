// The nearest hit of every ray of a dispatch; of one that asks for no more, any hit.

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
    hit.steps = steps;
    hits[at] = hit;
}

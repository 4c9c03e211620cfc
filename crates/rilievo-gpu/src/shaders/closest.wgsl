// The nearest hit of every ray of a dispatch among all faces.

@compute @workgroup_size(64)
fn closest(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = params.first + id.x;
    if at >= params.end {
        return;
    }
    let source = rays[at];
    steps = 0u;
    var best: Hit;
    best.surface = NOTHING;
    var t_max = source.t_max;
    for (var k = 0u; k < params.faces; k++) {
        face = k;
        let hit = meet_face(source, t_max, faces[k].surface);
        if hit.surface != NOTHING && (best.surface == NOTHING || below(hit.t, best.t)) {
            best = hit;
            t_max = hit.t;
        }
    }
    best.steps = steps;
    hits[at] = best;
}

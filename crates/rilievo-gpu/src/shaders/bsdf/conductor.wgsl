// The twin of `bsdf/conductor.rs`: a metal.

fn make_metal(part: ptr<function, Part>, material: u32) {
    let view = (*part).frame.view;
    (*part).by_index = scene[material + MODEL] != 0u;
    (*part).facing = inputs[OWN + 1u];
    (*part).edge = inputs[OWN + 2u];
    var facing = (*part).facing;
    if (*part).by_index {
        facing = absorbing_fresnel(1.0, (*part).facing, (*part).edge);
    } else {
        let cosine = 1.0 / 7.0;
        let schlick = facing + (1.0 - facing) * grazing(cosine);
        let edge = min((*part).edge, vec3<f32>(1.0));
        (*part).edge = schlick * (1.0 - edge) / (cosine * grazing(cosine) * (1.0 - cosine));
    }
    (*part).alpha = width_of(inputs[OWN].x);
    (*part).several = vec3<f32>(1.0);
    if scene[material + MODEL + 1u] != 0u && (*part).alpha >= SMOOTH {
        (*part).several = several_facets(facing, view.z, (*part).alpha);
    }
}

fn metal_at(part: Part, cosine: f32) -> vec3<f32> {
    if part.by_index {
        return absorbing_fresnel(cosine, part.facing, part.edge);
    }
    let edge = grazing(cosine);
    let value = part.facing + (1.0 - part.facing) * edge;
    return max(value - part.edge * (cosine * edge * (1.0 - cosine)), vec3<f32>(0.0));
}

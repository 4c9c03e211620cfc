// The twin of `sampler/warp.rs`.

fn square_to_disk(u: vec2<f32>) -> vec2<f32> {
    let p = 2.0 * u - 1.0;
    if all(p == vec2<f32>(0.0)) {
        return p;
    }
    if abs(p.x) > abs(p.y) {
        return p.x * sin_cos_eighth(p.y / p.x).yx;
    }
    return p.y * sin_cos_eighth(p.x / p.y);
}

fn square_to_hemisphere(u: vec2<f32>) -> vec3<f32> {
    let d = square_to_disk(u);
    return vec3<f32>(d, sqrt(max(1.0 - dot(d, d), 0.0)));
}

// Directions in a cone; its height is 1 less the cosine of its half angle.
fn square_to_cone(u: vec2<f32>, height: f32) -> vec3<f32> {
    let beneath = u.x * height;
    let sine = sqrt(max(beneath * (2.0 - beneath), 0.0));
    let turn = sin_cos_turns(u.y);
    return vec3<f32>(sine * turn.y, sine * turn.x, 1.0 - beneath);
}

fn cone_pdf(height: f32) -> f32 {
    return 1.0 / (2.0 * PI * height);
}

fn square_to_visible_normal(u: vec2<f32>, view: vec3<f32>, alpha: f32) -> vec3<f32> {
    let up = vec3<f32>(0.0, 0.0, 1.0);
    let stretched = unit_or(view * vec3<f32>(alpha, alpha, 1.0), up);
    // Where the lobe ends z comes near to -stretched.z: floats keep no digit of their sum, so it is not formed from them.
    let above = 1.0 + stretched.z;
    let height = (1.0 - u.x) * above;
    let beneath = height + dot(stretched.xy, stretched.xy) / above;
    let r = sqrt(max(u.x * above * beneath, 0.0));
    let turn = sin_cos_turns(u.y);
    let half = vec2<f32>(r * turn.y, r * turn.x) + stretched.xy;
    return unit_or(vec3<f32>(half * alpha, height), up);
}

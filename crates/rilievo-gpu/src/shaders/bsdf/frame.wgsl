// The twin of `bsdf/frame.rs`: the two normals of a hit, and local coordinates around the shading one.

struct Frame {
    right: vec3<f32>,
    up: vec3<f32>,
    normal: vec3<f32>,
    // The geometric normal and the direction to the viewer, in local coordinates; the latter has z >= 0.
    geometric: vec3<f32>,
    view: vec3<f32>,
}

// A direction in local coordinates, by both normals.
struct Side {
    light: vec3<f32>,
    // Its mirror image by the plane of the surface.
    image: vec3<f32>,
    height: f32,
    tilt: f32,
}

fn local_of(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(v, frame.right), dot(v, frame.up), dot(v, frame.normal));
}

fn world_of(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return v.x * frame.right + v.y * frame.up + v.z * frame.normal;
}

// The shading normal, tilted to a right angle with the view if the viewer sees it from behind.
fn visible_normal(geometric: vec3<f32>, shading: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    let cosine = dot(shading, view);
    if cosine >= 0.0 {
        return shading;
    }
    return unit_or(shading - cosine * view, geometric);
}

fn frame_of(point: Point, shading: vec3<f32>, view: vec3<f32>) -> Frame {
    let sign = select(-1.0, 1.0, point.front);
    let geometric = sign * point.geometric;
    var frame: Frame;
    frame.normal = visible_normal(geometric, sign * shading, view);
    frame.right = right_of(frame.normal);
    frame.up = up_of(frame.normal);
    frame.geometric = local_of(frame, geometric);
    frame.view = local_of(frame, view);
    frame.view.z = max(frame.view.z, 0.0);
    return frame;
}

fn side_of(frame: Frame, light: vec3<f32>) -> Side {
    let local = local_of(frame, light);
    let height = dot(local, frame.geometric);
    return Side(local, local - 2.0 * height * frame.geometric, height, frame.geometric.z);
}

// The factor that softens the terminator of a diffuse lobe where the normals differ.
fn softened(side: Side) -> f32 {
    if side.tilt <= 0.0 {
        return 1.0;
    }
    let ratio_of = abs(side.height) / (abs(side.light.z) * side.tilt);
    return select(1.0, ratio_of * (1.0 + ratio_of * (1.0 - ratio_of)), ratio_of < 1.0);
}

// The shading normal, turned by a normal in the tangent space of the surface.
fn detailed(point: Point, normal: vec3<f32>) -> vec3<f32> {
    let z = point.shading;
    let none = vec3<f32>(0.0);
    let x = unit_or(point.along_u - dot(point.along_u, z) * z, none);
    let y = unit_or(point.along_v - dot(point.along_v, z) * z, none);
    if is_black(x) || is_black(y) {
        return z;
    }
    return unit_or(normal.x * x + normal.y * y + normal.z * z, z);
}

//! [`LightBounds`]: what a group of lights can do to a point \[Conty2018\].

use glam::DVec3;

use super::Receiver;

/// Where the lights of a group are, where they shine and how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightBounds {
    /// Corners of a box around them.
    pub min: DVec3,
    pub max: DVec3,
    /// Largest radiant intensity that they send out, added up, W/sr.
    pub intensity: f64,
    /// Unit axis of a cone around the normals of the lights.
    pub axis: DVec3,
    /// Cosine of that cone's half angle; -1 for every direction.
    pub cos_normals: f64,
    /// Cosine of the largest angle between a normal and light that is sent out.
    pub cos_emission: f64,
    /// The part of the intensity whose importance is held, and at how much.
    pub held: f64,
    pub most: f64,
}

impl LightBounds {
    /// Around both.
    pub fn union(&self, other: &Self) -> Self {
        let (axis, cos_normals) = cone_around(self, other);
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            intensity: self.intensity + other.intensity,
            axis,
            cos_normals,
            cos_emission: self.cos_emission.min(other.cos_emission),
            held: self.held + other.held,
            most: self.most + other.most,
        }
    }

    /// The cost of a node that holds this group: its intensity, over the directions and places that
    /// it spans. `stretch` is the longest side of the parent over that along the split.
    pub fn cost(&self, stretch: f64) -> f64 {
        let (normals, emission) = (self.cos_normals.acos(), self.cos_emission.acos());
        let edge = (normals + emission).min(std::f64::consts::PI);
        // Integral of the sine over the cone of normals, and of the cosine's fall beyond it.
        let directions = std::f64::consts::TAU * (1.0 - self.cos_normals)
            + std::f64::consts::FRAC_PI_2
                * (2.0 * edge * normals.sin()
                    - (normals - 2.0 * edge).cos()
                    - 2.0 * normals * normals.sin()
                    + self.cos_normals);
        let side = self.max - self.min;
        let area = side.x * side.y + side.y * side.z + side.z * side.x;
        self.intensity * directions * stretch * area
    }

    /// What the intensity brings, a part of it at most `most`.
    #[inline]
    fn held_at(&self, brought: impl Fn(f64) -> f64, most: f64) -> f64 {
        let free = brought(self.intensity - self.held);
        if self.held > 0.0 { free + brought(self.held).min(most) } else { free }
    }

    /// An estimate of what the group brings to a receiver, 0 only where it can bring nothing.
    pub fn importance(&self, at: &Receiver) -> f64 {
        let half = 0.5 * (self.max - self.min);
        let way = at.position - (self.min + half);
        let squared = way.length_squared();
        let radius_squared = half.length_squared();
        // Within the box the distance to its middle says little. Measured on strewn lights: the lights
        // near the receiver get 2.5 times as many samples as with the whole radius.
        let reach = squared.max(0.1 * radius_squared).max(f64::MIN_POSITIVE);
        if squared <= radius_squared {
            // From within the sphere around the box light may come from everywhere.
            return self.held_at(|intensity| intensity / reach, BESIDE * self.most);
        }
        let towards = way / squared.sqrt();
        let sin2_box = radius_squared / squared;
        let (sin_box, cos_box) = (sin2_box.sqrt(), (1.0 - sin2_box).sqrt());
        let cos_axis = self.axis.dot(towards);
        let sin_axis = (1.0 - cos_axis * cos_axis).max(0.0).sqrt();
        let sin_normals = (1.0 - self.cos_normals * self.cos_normals).max(0.0).sqrt();
        // The smallest angle between a normal of the group and the way to the receiver: that to the
        // axis less those of the cone and of the box.
        let (cos, sin) = less((cos_axis, sin_axis), (self.cos_normals, sin_normals));
        let (cos, _) = less((cos, sin), (cos_box, sin_box));
        if cos <= self.cos_emission - ROUNDING {
            return 0.0;
        }
        let brought = |intensity| intensity * cos.max(ROUNDING) / reach;
        let mut importance = self.held_at(brought, self.most);
        if let Some(normal) = at.normal {
            let cos_in = -towards.dot(normal);
            let cos_in = if at.both_sides { cos_in.abs() } else { cos_in };
            let sin_in = (1.0 - cos_in * cos_in).max(0.0).sqrt();
            let (cos_in, _) = less((cos_in, sin_in), (cos_box, sin_box));
            if cos_in <= -ROUNDING {
                return 0.0;
            }
            importance *= cos_in.max(ROUNDING);
        }
        importance
    }
}

/// The share of what is held that counts beside or on its emitters: most of a relief is behind the
/// receiver's own plane then.
const BESIDE: f64 = 0.1;

/// Cosines this much too small are still taken for those that they are compared with.
const ROUNDING: f64 = 1e-6;

/// Cosine and sine of the first angle less the second, of 0 if that is larger.
fn less((cos_a, sin_a): (f64, f64), (cos_b, sin_b): (f64, f64)) -> (f64, f64) {
    if cos_a > cos_b {
        return (1.0, 0.0);
    }
    (cos_a * cos_b + sin_a * sin_b, sin_a * cos_b - cos_a * sin_b)
}

/// Axis and cosine of a cone around the normals of both.
fn cone_around(a: &LightBounds, b: &LightBounds) -> (DVec3, f64) {
    let angle = |bounds: &LightBounds| bounds.cos_normals.clamp(-1.0, 1.0).acos();
    let (half_a, half_b) = (angle(a), angle(b));
    let between = a.axis.angle_between(b.axis);
    let all = std::f64::consts::PI;
    if (between + half_b).min(all) <= half_a {
        return (a.axis, a.cos_normals);
    }
    if (between + half_a).min(all) <= half_b {
        return (b.axis, b.cos_normals);
    }
    let half = 0.5 * (half_a + between + half_b);
    let across = a.axis.cross(b.axis);
    match across.try_normalize() {
        Some(across) if half < all => {
            let turned = glam::DQuat::from_axis_angle(across, half - half_a) * a.axis;
            // A little wider, for what was rounded.
            (turned.normalize(), (half + 1e-9).min(all).cos())
        }
        _ => (a.axis, -1.0),
    }
}

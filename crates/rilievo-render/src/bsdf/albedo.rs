//! What rough interfaces send back in all, and what is lost to further facets.
//!
//! A facet model counts light that meets one facet. The rest, up to 60 % of it on a rough metal, goes to
//! further facets, and most of it comes back in the end. \[Turquin2019\] puts it back with the shape
//! of the lobe that is there: divide by the share `E` that single facets send back. `E` depends on the
//! view's cosine and the roughness (and the index, of a clear body); it is integrated here over
//! visible normals, with the midpoint rule, when it is first needed, in some 10 ms a
//! table. That the scale of a lobe depends on the view alone gives up reciprocity; that
//! a white furnace stays white is tested.
//!
//! With Schlick's formula `E = facing A + grazing B`, so two numbers serve all colours.

use std::f64::consts::PI;
use std::sync::{Arc, LazyLock, OnceLock};

use glam::{DVec2, DVec3};

use super::fresnel;
use super::microfacet::{masked_share, transmitted};
use super::sheen;
use crate::sampler::warp;
use crate::scene::MaterialError;

/// Nodes along the root of the cosine, close at grazing angles, and along the roughness.
const NODES: [usize; 2] = [32, 24];

/// Facets along the two axes of the quadrature; the second covers half a turn.
const FACETS: [usize; 2] = [32, 8];

/// Numbers over the view's cosine and the roughness, linear in between.
struct Grid(Vec<[f64; 2]>);

impl Grid {
    /// Tabulates `value` of (cosine, roughness).
    fn new(value: impl Fn(f64, f64) -> [f64; 2]) -> Self {
        let [n, m] = NODES;
        let node = |k: usize, of: usize| k as f64 / (of - 1) as f64;
        Self((0..n * m).map(|k| value(node(k % n, n).powi(2), node(k / n, m))).collect())
    }

    /// At a cosine and a GGX width in `[0, 1]`.
    fn at(&self, cosine: f64, alpha: f64) -> [f64; 2] {
        let [n, m] = NODES;
        let place = |x: f64, of: usize| {
            let x = x.clamp(0.0, 1.0) * (of - 1) as f64;
            let k = (x as usize).min(of - 2);
            (k, x - k as f64)
        };
        let ((i, s), (j, t)) = (place(cosine.max(0.0).sqrt(), n), place(alpha.sqrt(), m));
        let row = |j: usize| {
            let [a, b] = [self.0[j * n + i], self.0[j * n + i + 1]].map(DVec2::from);
            a.lerp(b, s)
        };
        row(j).lerp(row(j + 1), t).to_array()
    }
}

/// The mean of `value(view, facet)` over the facets that are seen from a cosine.
fn over_facets(cosine: f64, alpha: f64, value: impl Fn(DVec3, DVec3) -> [f64; 2]) -> [f64; 2] {
    let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let [n, m] = FACETS;
    let (mut sum, mut weights) = (DVec2::ZERO, 0.0);
    for k in 0..n * m {
        // The square: steep facets are few, and it is they that lose light. Half a turn: the
        // other half is its mirror image.
        let tail = 1.0 - ((k % n) as f64 + 0.5) / n as f64;
        let u = DVec2::new(1.0 - tail * tail, 0.5 * ((k / n) as f64 + 0.5) / m as f64);
        sum += tail * DVec2::from(value(view, warp::square_to_visible_normal(u, view, alpha)));
        weights += tail;
    }
    (sum / weights).to_array()
}

/// The factors `[A, B]` of the reflectances straight on and at grazing angles in what a rough surface
/// reflects in all.
pub(super) fn gloss(cosine: f64, alpha: f64) -> [f64; 2] {
    GLOSS.at(cosine, alpha)
}

/// Of [`gloss`].
static GLOSS: LazyLock<Grid> = LazyLock::new(|| {
    Grid::new(|cosine, roughness| {
        let alpha = (roughness * roughness).max(1e-6);
        over_facets(cosine, alpha, |view, facet| {
            let c = view.dot(facet);
            let light = 2.0 * c * facet - view;
            let share = if light.z > 0.0 { masked_share(view, light, alpha) } else { 0.0 };
            let edge = fresnel::grazing(c);
            [share * (1.0 - edge), share * edge]
        })
    })
});

/// The factors of [`gloss`] over [`NODES`], row by row.
pub(crate) fn gloss_table() -> Vec<[f64; 2]> {
    GLOSS.0.clone()
}

/// What a sheen of a roughness reflects in all.
pub(super) fn sheen_albedo(cosine: f64, roughness: f64) -> f64 {
    SHEEN.at(cosine, roughness * roughness)[0]
}

/// Of [`sheen_albedo`].
static SHEEN: LazyLock<Grid> = LazyLock::new(|| {
    Grid::new(|cosine, roughness| {
        let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let (n, m) = (20, 12);
        let all = (0..n * m).map(|k| {
            // The square: close where light grazes.
            let root = ((k % n) as f64 + 0.5) / n as f64;
            let height = root * root;
            let (sin, cos) = (PI * ((k / n) as f64 + 0.5) / m as f64).sin_cos();
            let r = (1.0 - height * height).sqrt();
            let light = DVec3::new(r * cos, r * sin, height);
            4.0 * PI * root * height * sheen::fibres(view, light, roughness)
        });
        [all.sum::<f64>() / (n * m) as f64, 0.0]
    })
});

/// The numbers of [`sheen_albedo`], first of each pair, over [`NODES`], row by row.
pub(crate) fn sheen_table() -> Vec<[f64; 2]> {
    SHEEN.0.clone()
}

/// An index of refraction, and what a rough interface of it reflects and lets through in all.
pub struct GlassTable {
    ior: f64,
    /// Seen from the front, and from behind.
    sides: [OnceLock<Grid>; 2],
}

impl GlassTable {
    /// Indices that are allowed.
    pub const IORS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

    /// Of the index of the side behind the front over that before it.
    ///
    /// # Errors
    /// [`MaterialError::Ior`] if it is not in [`Self::IORS`].
    pub fn new(ior: f64) -> Result<Self, MaterialError> {
        match Self::IORS.contains(&ior) {
            true => Ok(Self { ior, sides: Default::default() }),
            false => Err(MaterialError::Ior { found: ior }),
        }
    }

    /// Of index 1.5: common glass and plastic.
    pub fn common() -> Arc<Self> {
        Arc::new(Self { ior: 1.5, sides: Default::default() })
    }

    /// The index.
    pub fn ior(&self) -> f64 {
        self.ior
    }

    /// The share that single facets send on, to either side.
    pub(super) fn at(&self, front: bool, cosine: f64, alpha: f64) -> f64 {
        self.side(front).at(cosine, alpha)[0]
    }

    /// The tables of both sides, seen from behind and from the front: the first of each pair over [`NODES`], row by row.
    pub(crate) fn sides(&self) -> [Vec<[f64; 2]>; 2] {
        [false, true].map(|front| self.side(front).0.clone())
    }

    fn side(&self, front: bool) -> &Grid {
        let eta = if front { self.ior } else { 1.0 / self.ior };
        self.sides[usize::from(front)].get_or_init(|| {
            Grid::new(|cosine, roughness| {
                let alpha = (roughness * roughness).max(1e-6);
                over_facets(cosine, alpha, |view, facet| {
                    let c = view.dot(facet);
                    let (share, inside) = fresnel::clear(c, eta);
                    let up = 2.0 * c * facet - view;
                    let mut sum =
                        if up.z > 0.0 { share * masked_share(view, up, alpha) } else { 0.0 };
                    let down = transmitted(view, facet, (c, inside), eta);
                    if share < 1.0 && down.z < 0.0 {
                        sum += (1.0 - share) * masked_share(view, down, alpha);
                    }
                    [sum, 0.0]
                })
            })
        })
    }
}

impl PartialEq for GlassTable {
    fn eq(&self, other: &Self) -> bool {
        self.ior == other.ior
    }
}

impl std::fmt::Debug for GlassTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GlassTable").field("ior", &self.ior).finish_non_exhaustive()
    }
}

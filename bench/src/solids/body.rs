//! [`Body`]: what carries the map, displaced by rilievo and tessellated for its peer.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ValueEnum;
use glam::{DVec2, DVec3};
use rilievo::Ray;
use rilievo::map::{CubeFace, CubeHeights, HeightMap, Layout, Tiling};
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{
    CubeRelief, Displacement, Edges, MeshOptions, Relief, ReliefMesh, ReliefSphere, SphereOptions,
};
use rilievo::surface::Surface;
use rilievo_io::Limits;
use rilievo_io::mesh::Model;

use super::tessellation::Triangles;

/// A base surface by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Body {
    /// A unit sphere; the map lies on it as longitude and latitude, resampled to six faces.
    Sphere,
    /// A torus of 9216 triangles, radii 1 and 0.4.
    Torus,
    /// The mesh of the scene spot.
    Spot,
}

/// A body under a map.
pub struct Displaced {
    pub surface: Surface,
    /// What thickness is a share of: the diagonal of the base's box, or the sphere's radius.
    pub size: f64,
    /// Bytes that rilievo holds beyond the heights.
    pub bytes: u64,
    base: Base,
}

enum Base {
    Sphere(Arc<CubeRelief>, Displacement),
    Mesh(Box<ReliefMesh>),
}

impl Body {
    pub const ALL: [Self; 3] = [Self::Sphere, Self::Torus, Self::Spot];

    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Torus => "torus",
            Self::Spot => "spot",
        }
    }

    /// The body under `map`, as thick as a share of its size.
    ///
    /// # Errors
    /// A mesh that cannot be read, or what rilievo refuses.
    pub fn displaced(self, map: &HeightMap, thickness: f64) -> Result<Displaced, String> {
        match self {
            Self::Sphere => sphere(map, thickness),
            Self::Torus => mesh(torus([96, 48]), map, thickness, Edges::Shared),
            Self::Spot => mesh(spot()?, map, thickness, Edges::Shared),
        }
    }

    /// The same, seams of meshes open, as in a tessellation: no body's file has normals of its own, so
    /// nothing else differs.
    ///
    /// # Errors
    /// As [`Body::displaced`].
    pub fn without_walls(self, map: &HeightMap, thickness: f64) -> Result<Displaced, String> {
        match self {
            Self::Sphere => sphere(map, thickness),
            Self::Torus => mesh(torus([96, 48]), map, thickness, Edges::AsAuthored),
            Self::Spot => mesh(spot()?, map, thickness, Edges::AsAuthored),
        }
    }
}

/// Heights from 0 to `thickness` of a size, as a displacement outward and inward by half.
fn centred(size: f64, thickness: f64) -> Displacement {
    Displacement { scale: thickness * size, zero: 0.5, ..Displacement::default() }
}

fn sphere(map: &HeightMap, thickness: f64) -> Result<Displaced, String> {
    let heights = CubeHeights::resample(map, Tiling::default()).map_err(|e| e.to_string())?;
    let relief = Arc::new(CubeRelief::with_layout(heights, Layout::Default));
    let displacement = centred(1.0, thickness);
    let options = SphereOptions { displacement, ..SphereOptions::default() };
    let sphere = ReliefSphere::new(DVec3::ZERO, 1.0, Arc::clone(&relief), options);
    let sphere = sphere.map_err(|e| e.to_string())?;
    let bytes = relief.bytes().1;
    let base = Base::Sphere(relief, displacement);
    Ok(Displaced { surface: sphere.into(), size: 1.0, bytes, base })
}

fn mesh(
    data: MeshData,
    map: &HeightMap,
    thickness: f64,
    edges: Edges,
) -> Result<Displaced, String> {
    let relief = Arc::new(Relief::new(map.clone()));
    let low = data.positions.iter().fold(DVec3::INFINITY, |low, &p| low.min(p));
    let high = data.positions.iter().fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
    let size = (high - low).length();
    let displacement = centred(size, thickness);
    let options = MeshOptions { displacement, edges, ..MeshOptions::default() };
    let base = Mesh::new(data).map_err(|e| e.to_string())?;
    let mesh = ReliefMesh::new(&base, Arc::clone(&relief), options).map_err(|e| e.to_string())?;
    let bytes = mesh.bytes() + relief.bytes().1;
    let base = Base::Mesh(Box::new(mesh.clone()));
    Ok(Displaced { surface: mesh.into(), size, bytes, base })
}

impl Displaced {
    /// Parameter of the nearest crossing.
    pub fn first_crossing(&self, ray: &Ray) -> Option<f64> {
        match &self.surface {
            Surface::ReliefMesh(mesh) => mesh.first_crossing(ray, &mut ()).map(|found| found.t),
            Surface::ReliefSphere(sphere) => {
                sphere.first_crossing(ray, &mut ()).map(|found| found.t)
            }
            other => other.closest(ray, &mut ()).map(|hit| hit.t),
        }
    }

    /// The same surface in triangles, two for each texel cut in `density` along both sides.
    pub fn tessellate(&self, density: u32) -> Triangles {
        let mut to = Triangles::default();
        match &self.base {
            Base::Sphere(relief, displacement) => {
                for face in CubeFace::ALL {
                    add_face(&mut to, (relief, face), displacement, density);
                }
            }
            Base::Mesh(mesh) => {
                for triangle in 0..mesh.data().triangles.len() as u32 {
                    // As many parts as there are halves of texels under it.
                    let cuts = (2.0 * mesh.cells_under(triangle)).sqrt().ceil().max(1.0) as u32;
                    let cuts = cuts * density;
                    to.add_triangle(cuts, |weights| mesh.point(triangle, weights));
                }
            }
        }
        to
    }
}

/// One face of a cube, each cell cut into `density` x `density`.
fn add_face(
    to: &mut Triangles,
    (relief, face): (&CubeRelief, CubeFace),
    displacement: &Displacement,
    density: u32,
) {
    let (cells, heights) = (relief.cells(), relief.face(face).heights());
    let at = |x: f64| 2.0 * x / f64::from(cells) - 1.0;
    // 1/Z is bilinear between lattice points.
    let inverse = |i: u32, j: u32| {
        let height = f64::from(heights.raw(i, j)) * heights.unit();
        let along = DVec3::new(at(f64::from(i)), at(f64::from(j)), 1.0);
        along.length() / (1.0 + displacement.scale * (height - displacement.zero))
    };
    let side = cells * density + 1;
    to.add_grid([side; 2], |i, j| {
        let cell = [i, j].map(|k| (k / density).min(cells - 1));
        let [x, y] = [0, 1].map(|k| f64::from([i, j][k]) / f64::from(density));
        let (u, v) = (x - f64::from(cell[0]), y - f64::from(cell[1]));
        let row = |j: u32| (1.0 - u) * inverse(cell[0], j) + u * inverse(cell[0] + 1, j);
        let z = 1.0 / ((1.0 - v) * row(cell[1]) + v * row(cell[1] + 1));
        face.from_frame([at(x) * z, at(y) * z, z])
    });
}

/// A torus around the z axis of `u` x `v` quads, the map on it once.
fn torus([u, v]: [u32; 2]) -> MeshData {
    let mut data = MeshData::default();
    for j in 0..=v {
        for i in 0..=u {
            let at = DVec2::new(f64::from(i) / f64::from(u), f64::from(j) / f64::from(v));
            data.uvs.push(at);
            if i < u && j < v {
                let (around, across) = ((TAU * at.x).sin_cos(), (TAU * at.y).sin_cos());
                let r = 1.0 + 0.4 * across.1;
                data.positions.push(DVec3::new(r * around.1, r * around.0, 0.4 * across.0));
            }
        }
    }
    let position = |i: u32, j: u32| j % v * u + i % u;
    let uv = |i: u32, j: u32| j * (u + 1) + i;
    for j in 0..v {
        for i in 0..u {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let three = [corners[a], corners[b], corners[c]];
                data.triangles.push(Triangle {
                    positions: three.map(|[i, j]| position(i, j)),
                    normals: None,
                    uvs: Some(three.map(|[i, j]| uv(i, j))),
                });
            }
        }
    }
    data
}

fn spot() -> Result<MeshData, String> {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/spot/spot.obj");
    let model = Model::read(&path, &Limits::default()).map_err(|e| e.to_string())?;
    Ok(model.mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn the_tessellation_lies_on_the_surface() {
        let map = MapName::Gaussian.load(65).unwrap();
        for body in Body::ALL {
            let displaced = body.displaced(&map, 0.02).unwrap();
            let triangles = displaced.tessellate(1);
            let points =
                triangles.positions.iter().step_by(97).map(|p| DVec3::from(p.map(f64::from)));
            for point in points {
                // Of three crossing lines through the point, one at least is not along the surface.
                let near = DVec3::AXES.into_iter().any(|axis| {
                    let ray = Ray::between(point - 0.01 * axis, point + 0.01 * axis);
                    let hit = displaced.surface.closest(&ray, &mut ());
                    hit.is_some_and(|hit| (hit.position - point).length() < 2e-3)
                });
                assert!(near, "{body:?}: {point}");
            }
        }
    }
}

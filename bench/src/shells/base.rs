//! [`Base`]: the meshes that are displaced.

use std::f64::consts::TAU;
use std::path::Path;

use clap::ValueEnum;
use glam::{DVec2, DVec3};
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo_io::Limits;
use rilievo_io::mesh::Model;

/// A mesh by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Base {
    /// The model of `scenes/spot`: 5856 triangles, folded ears and legs.
    Spot,
    /// A torus of 9216 triangles.
    Torus,
    /// A torus of 576 triangles.
    Coarse,
}

impl Base {
    pub const ALL: [Self; 3] = [Self::Spot, Self::Torus, Self::Coarse];

    pub fn name(self) -> &'static str {
        match self {
            Self::Spot => "spot",
            Self::Torus => "torus",
            Self::Coarse => "coarse",
        }
    }

    /// The mesh.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn mesh(self) -> Result<Mesh, String> {
        let data = match self {
            Self::Spot => {
                let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
                let path = root.join("scenes/spot/spot.obj");
                Model::read(&path, &Limits::default()).map_err(|e| e.to_string())?.mesh
            }
            Self::Torus => torus(96, 48),
            Self::Coarse => torus(24, 12),
        };
        Mesh::new(data).map_err(|e| e.to_string())
    }
}

/// A torus of radii 1 and 0.4.
fn torus(around: u32, across: u32) -> MeshData {
    let mut data = MeshData::default();
    for j in 0..across {
        for i in 0..around {
            let angle = |k: u32, n: u32| TAU * f64::from(k) / f64::from(n);
            let (a, b) = (angle(i, around), angle(j, across));
            let out = DVec3::new(a.cos(), a.sin(), 0.0);
            data.positions.push(out + 0.4 * (b.cos() * out + b.sin() * DVec3::Z));
        }
    }
    for j in 0..=across {
        for i in 0..=around {
            let at = |k: u32, n: u32| f64::from(k) / f64::from(n);
            data.uvs.push(DVec2::new(at(i, around), at(j, across)));
        }
    }
    for j in 0..across {
        for i in 0..around {
            for corners in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
                let positions = corners.map(|(x, y)| (j + y) % across * around + (i + x) % around);
                let uvs = Some(corners.map(|(x, y)| (j + y) * (around + 1) + i + x));
                data.triangles.push(Triangle { positions, normals: None, uvs });
            }
        }
    }
    data
}

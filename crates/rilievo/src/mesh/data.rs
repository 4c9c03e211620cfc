//! [`MeshData`]: what a mesh is made of, and [`Mesh`]: the same, checked and ready to trace.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use thiserror::Error;

use super::triangle::triangle_normal;
use crate::accel::{Aabb, Bvh};

/// Largest coordinate of a mesh or quad: products of three such numbers stay finite.
pub const COORDINATE_LIMIT: f64 = 1e100;

/// Triangles a leaf of the tree may hold.
const LEAF_TRIANGLES: u32 = 4;

/// Indices into a [`MeshData`], corner by corner, counter-clockwise seen from the front.
/// Positions, normals and uvs are numbered apart, as in OBJ files: neighbours that share
/// positions stay watertight across uv seams and hard edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Into [`MeshData::positions`].
    pub positions: [u32; 3],
    /// Into [`MeshData::normals`]; without them the triangle is shaded flat.
    pub normals: Option<[u32; 3]>,
    /// Into [`MeshData::uvs`]; without them uv are the weights of the second and third corner.
    pub uvs: Option<[u32; 3]>,
}

/// The parts of a mesh, unchecked. Polygons have been fanned from their first corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Scene units, world space.
    pub positions: Vec<DVec3>,
    /// Any length; a zero vector counts as none.
    pub normals: Vec<DVec3>,
    /// Texture coordinates.
    pub uvs: Vec<DVec2>,
    /// The faces.
    pub triangles: Vec<Triangle>,
}

/// Why a mesh was refused.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum MeshError {
    /// There is nothing to trace.
    #[error("the mesh has no triangles")]
    Empty,
    /// Indices of triangles are 31 bits wide.
    #[error("the mesh has {0} triangles, more than 2^31 - 1")]
    TooManyTriangles(usize),
    /// A position is NaN, infinite or beyond [`COORDINATE_LIMIT`].
    #[error("position {0} is not finite or larger than 1e100")]
    Position(usize),
    /// A normal is NaN or infinite.
    #[error("normal {0} is not finite")]
    Normal(usize),
    /// A uv is NaN or infinite.
    #[error("texture coordinate {0} is not finite")]
    Uv(usize),
    /// A triangle names a position, normal or uv that is not there.
    #[error("triangle {triangle} names {attribute} {index}, but there are only {count}")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// "position", "normal" or "texture coordinate".
        attribute: &'static str,
        /// The index found.
        index: u32,
        /// The number there are.
        count: usize,
    },
    /// A transform that flattens space or is not finite.
    #[error("the transform cannot be inverted")]
    Transform,
}

/// A triangle mesh in world space, ready to trace. See the [module](super) for what is promised.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(super) data: MeshData,
    /// The triangles that can be hit; items of the tree are places in this list.
    pub(super) solid: Vec<u32>,
    pub(super) tree: Bvh,
}

impl Mesh {
    /// Checks the parts and builds the tree.
    ///
    /// # Errors
    /// The first fault found: see [`MeshError`].
    pub fn new(data: MeshData) -> Result<Self, MeshError> {
        data.check()?;
        let corners = |index: u32| {
            data.triangles[index as usize].positions.map(|i| data.positions[i as usize])
        };
        let solid: Vec<u32> = (0..data.triangles.len() as u32)
            .filter(|&index| triangle_normal(&corners(index)).is_some())
            .collect();
        let boxes: Vec<Aabb> = solid.iter().map(|&index| Aabb::around(corners(index))).collect();
        let tree = Bvh::build(&boxes, LEAF_TRIANGLES);
        Ok(Self { data, solid, tree })
    }

    /// The mesh placed by `world_from_object`. Normals follow by the inverse transpose; a
    /// transform that mirrors turns every triangle round, so that the front stays the front.
    ///
    /// # Errors
    /// [`MeshError::Transform`], or [`MeshError::Position`] if a position leaves the limit.
    pub fn transformed(self, world_from_object: DAffine3) -> Result<Self, MeshError> {
        let matrix = world_from_object.matrix3;
        let cofactors = DMat3::from_cols(
            matrix.y_axis.cross(matrix.z_axis),
            matrix.z_axis.cross(matrix.x_axis),
            matrix.x_axis.cross(matrix.y_axis),
        );
        let determinant = matrix.determinant();
        if !world_from_object.is_finite() || determinant == 0.0 || !determinant.is_finite() {
            return Err(MeshError::Transform);
        }
        let mut data = self.data;
        for p in &mut data.positions {
            *p = world_from_object.transform_point3(*p);
        }
        for n in &mut data.normals {
            let unit = n.try_normalize().unwrap_or(DVec3::ZERO);
            *n = (cofactors * unit * determinant.signum()).try_normalize().unwrap_or(DVec3::ZERO);
        }
        if determinant < 0.0 {
            for triangle in &mut data.triangles {
                triangle.positions.swap(1, 2);
                for indices in [&mut triangle.normals, &mut triangle.uvs].into_iter().flatten() {
                    indices.swap(1, 2);
                }
            }
        }
        Self::new(data)
    }

    /// What the mesh is made of.
    pub fn data(&self) -> &MeshData {
        &self.data
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.data.triangles[triangle as usize].positions.map(|i| self.data.positions[i as usize])
    }

    /// The number of triangles that are never hit because they have no area.
    pub fn degenerate(&self) -> usize {
        self.data.triangles.len() - self.solid.len()
    }

    /// Memory held, in bytes, the tree included.
    pub fn bytes(&self) -> u64 {
        let solid = size_of_val(self.solid.as_slice()) as u64;
        self.data.bytes() + solid + self.tree.bytes()
    }
}

impl MeshData {
    /// Memory held, in bytes.
    pub fn bytes(&self) -> u64 {
        let Self { positions, normals, uvs, triangles } = self;
        let parts = size_of_val(positions.as_slice())
            + size_of_val(normals.as_slice())
            + size_of_val(uvs.as_slice())
            + size_of_val(triangles.as_slice());
        parts as u64
    }

    /// How far one unit of u and one of v reach on the mesh, scene units: means over the area of all
    /// triangles whose uv span an area. `None` if there are none.
    ///
    /// # Panics
    /// If a triangle names a position or uv that is not there.
    pub fn lengths_of_uv(&self) -> Option<[f64; 2]> {
        let (mut sum, mut total) = ([0.0; 2], 0.0);
        for triangle in &self.triangles {
            let Some(uvs) = triangle.uvs else { continue };
            let [a, b, c] = triangle.positions.map(|p| self.positions[p as usize]);
            let [p, q, r] = uvs.map(|uv| self.uvs[uv as usize]);
            let (along, across) = (b - a, c - a);
            let (e, f) = (q - p, r - p);
            let turn = e.perp_dot(f);
            let u = (along * f.y - across * e.y) / turn;
            let v = (across * e.x - along * f.x) / turn;
            let area = along.cross(across).length();
            let lengths = [u.length() * area, v.length() * area];
            if lengths.iter().all(|x| x.is_finite()) {
                sum = [sum[0] + lengths[0], sum[1] + lengths[1]];
                total += area;
            }
        }
        let lengths = sum.map(|x| x / total);
        lengths.iter().all(|x| x.is_finite() && *x > 0.0).then_some(lengths)
    }

    fn check(&self) -> Result<(), MeshError> {
        if self.triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        if self.triangles.len() >= 1 << 31 {
            return Err(MeshError::TooManyTriangles(self.triangles.len()));
        }
        // Negated, so that NaN is refused.
        let wild = |p: &DVec3| !p.abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all();
        if let Some(i) = self.positions.iter().position(wild) {
            return Err(MeshError::Position(i));
        }
        if let Some(i) = self.normals.iter().position(|n| !n.is_finite()) {
            return Err(MeshError::Normal(i));
        }
        if let Some(i) = self.uvs.iter().position(|uv| !uv.is_finite()) {
            return Err(MeshError::Uv(i));
        }
        for (number, triangle) in self.triangles.iter().enumerate() {
            for (attribute, indices, count) in [
                ("position", Some(triangle.positions), self.positions.len()),
                ("normal", triangle.normals, self.normals.len()),
                ("texture coordinate", triangle.uvs, self.uvs.len()),
            ] {
                let beyond = indices.into_iter().flatten().find(|&index| index as usize >= count);
                if let Some(index) = beyond {
                    return Err(MeshError::Index { triangle: number, attribute, index, count });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids;
    use crate::ray::Ray;

    #[test]
    fn faults_are_named() {
        let good = solids::cube();
        let fault = |damage: &dyn Fn(&mut MeshData)| {
            let mut data = good.clone();
            data.normals = vec![DVec3::Z];
            data.uvs = vec![DVec2::ZERO];
            damage(&mut data);
            Mesh::new(data).expect_err("damaged")
        };
        assert_eq!(Mesh::new(MeshData::default()).unwrap_err(), MeshError::Empty);
        for bad in [f64::NAN, f64::INFINITY, -1e101] {
            assert_eq!(fault(&|d| d.positions[3].y = bad), MeshError::Position(3));
        }
        assert_eq!(fault(&|d| d.normals[0].x = f64::NAN), MeshError::Normal(0));
        assert_eq!(fault(&|d| d.uvs[0].y = f64::INFINITY), MeshError::Uv(0));
        let index = |triangle, attribute, index, count| MeshError::Index {
            triangle,
            attribute,
            index,
            count,
        };
        assert_eq!(fault(&|d| d.triangles[2].positions[1] = 8), index(2, "position", 8, 8));
        assert_eq!(fault(&|d| d.triangles[5].normals = Some([0, 0, 1])), index(5, "normal", 1, 1));
        let error = fault(&|d| d.triangles[5].uvs = Some([u32::MAX; 3]));
        assert_eq!(error, index(5, "texture coordinate", u32::MAX, 1));
    }

    #[test]
    fn degenerate_triangles_are_counted_and_never_hit() {
        let mut data = solids::cube();
        data.triangles.push(Triangle { positions: [0, 0, 6], normals: None, uvs: None });
        let mesh = Mesh::new(data.clone()).expect("valid");
        assert_eq!(mesh.degenerate(), 1);
        data.triangles.drain(..12);
        let flat = Mesh::new(data).expect("valid");
        assert_eq!(flat.degenerate(), 1);
        assert!(flat.bounds().is_empty());
        assert_eq!(flat.closest(&Ray::new(DVec3::splat(-2.0), DVec3::ONE), &mut ()), None);
    }

    #[test]
    fn transforms_keep_the_front() {
        let mut data = solids::subdivided_sphere(1);
        data.normals = data.positions.clone();
        for t in &mut data.triangles {
            t.normals = Some(t.positions);
        }
        let mesh = Mesh::new(data).expect("valid");
        for scale in [DVec3::new(2.0, 1.0, 0.5), DVec3::new(-2.0, 1.0, 0.5)] {
            let place = DAffine3::from_scale(scale) * DAffine3::from_rotation_x(0.3);
            let placed = mesh.clone().transformed(place).expect("valid");
            for direction in [DVec3::X, DVec3::Y, -DVec3::Z] {
                let direction = (direction + 0.01).normalize();
                let hit =
                    placed.closest(&Ray::new(5.0 * direction, -direction), &mut ()).expect("hit");
                assert!(hit.front && hit.geometric_normal.dot(direction) > 0.0);
                // The normal of an ellipsoid is the gradient of x^2/a^2 + y^2/b^2 + z^2/c^2; the
                // interpolated one is near it.
                let exact = (hit.position / (scale * scale)).normalize();
                assert!(hit.shading_normal.dot(exact) > 0.99);
            }
        }
        let flat = DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.clone().transformed(flat).unwrap_err(), MeshError::Transform);
        let far = DAffine3::from_translation(DVec3::splat(1e200));
        assert_eq!(mesh.transformed(far).unwrap_err(), MeshError::Position(0));
    }

    #[test]
    fn memory_is_accounted_for() {
        let mesh = Mesh::new(solids::cube()).expect("valid");
        let least = 8 * size_of::<DVec3>() + 12 * size_of::<Triangle>();
        assert!(mesh.bytes() > least as u64 && mesh.bytes() < 8192);
    }
}

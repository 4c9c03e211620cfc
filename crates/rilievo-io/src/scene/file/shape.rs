//! `[[shapes]]`.

use std::ops::Range;

use rilievo::glam::{DAffine3, DMat3, DVec3, EulerRot};
use rilievo::map::NormalConvention;
use rilievo::relief::{Displacement, Edges, Method};
use rilievo::surface::Motion;

use super::super::keys::material::CONVENTION;
use super::super::keys::place;
use super::super::keys::render::METHOD_OF_SHAPE;
use super::super::keys::shape::{self as keys, NormalsKind, ShapeKind};
use super::super::syntax::{Located, Table, Value};
use super::instances::{InstanceEntry, read_instances};
use super::motion::read_motion;
use super::terrain::{GroundEntry, read_terrain};
use crate::error::Result;
use crate::mesh::Projection;

/// Which normals a displaced shape is shaded with.
#[derive(Clone, Debug)]
pub(in super::super) enum Normals {
    Exact,
    Smooth,
    Published,
    WrongMetric,
    /// A normal map.
    File {
        file: Located<String>,
        /// None of a texture set, until it is measured.
        convention: Option<NormalConvention>,
    },
}

/// What `displacement` says.
#[derive(Clone, Debug)]
pub(in super::super) struct DisplacementEntry {
    pub map: Located<String>,
    pub displacement: Displacement,
    /// Whether the scene says them; a texture set fills them in otherwise.
    pub scale_written: bool,
    pub zero_written: bool,
    pub normals: Normals,
    pub at: Range<usize>,
}

/// A quad.
#[derive(Clone, Debug)]
pub(in super::super) struct QuadEntry {
    pub corners: Located<[DVec3; 4]>,
    pub displacement: Option<DisplacementEntry>,
    pub method: Option<Method>,
    pub closed: bool,
    pub one_sided: bool,
    /// Of a terrain, what its corners follow from.
    pub ground: Option<Box<GroundEntry>>,
}

/// A sphere.
#[derive(Clone, Debug)]
pub(in super::super) struct SphereEntry {
    pub center: DVec3,
    pub radius: Located<f64>,
    pub displacement: Option<DisplacementEntry>,
    pub method: Option<Method>,
}

/// A mesh.
#[derive(Clone, Debug)]
pub(in super::super) struct MeshEntry {
    pub file: Located<String>,
    /// Gives it texture coordinates in place of its own.
    pub projection: Option<Projection>,
    /// Whether faces without normals are smooth.
    pub smooth: bool,
    pub world_from_object: Option<Located<DAffine3>>,
    pub displacement: Option<DisplacementEntry>,
    pub edges: Edges,
    /// Whether the map is baked towards equal heights at seams.
    pub matched: bool,
    pub method: Option<Method>,
    pub closed: bool,
    pub one_sided: bool,
}

/// A shape.
#[derive(Clone, Debug)]
pub(in super::super) enum Shape {
    Quad(QuadEntry),
    Sphere(SphereEntry),
    Mesh(MeshEntry),
}

/// What an entry of `[[shapes]]` says.
#[derive(Clone, Debug)]
pub(in super::super) struct ShapeEntry {
    pub shape: Shape,
    pub material: Option<Located<String>>,
    /// Where it stands, if not once where it is.
    pub instances: Option<Vec<InstanceEntry>>,
    /// Where it goes, in its own frame.
    pub motion: Option<Located<Motion>>,
}

impl Shape {
    /// What displaces it.
    pub fn displacement(&self) -> Option<&DisplacementEntry> {
        match self {
            Self::Quad(quad) => quad.displacement.as_ref(),
            Self::Sphere(sphere) => sphere.displacement.as_ref(),
            Self::Mesh(mesh) => mesh.displacement.as_ref(),
        }
    }

    /// The same, to be rewritten.
    pub fn displacement_mut(&mut self) -> Option<&mut DisplacementEntry> {
        match self {
            Self::Quad(quad) => quad.displacement.as_mut(),
            Self::Sphere(sphere) => sphere.displacement.as_mut(),
            Self::Mesh(mesh) => mesh.displacement.as_mut(),
        }
    }
}

impl ShapeEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let kind = keys::TYPE.of(table)?;
        let material = keys::MATERIAL.of(table)?;
        let shape = match kind {
            ShapeKind::Quad => Shape::Quad(read_quad(table)?),
            ShapeKind::Sphere => Shape::Sphere(read_sphere(table)?),
            ShapeKind::Mesh => Shape::Mesh(read_mesh(table)?),
            ShapeKind::Terrain => Shape::Quad(read_terrain(table)?),
        };
        let motion = read_motion(table)?;
        let instances = read_instances(table, motion.is_some())?;
        table.finish()?;
        Ok(Self { shape, material, instances, motion })
    }
}

/// The displacement of a shape; refuses what is `of_relief` alone where there is none.
fn read_displacement(
    table: &Table<'_>,
    (shape, of_relief): (&str, &[Option<Value<'_>>]),
) -> Result<Option<DisplacementEntry>> {
    match (table.get(&keys::DISPLACEMENT_TABLE), of_relief.iter().flatten().next()) {
        (None, Some(value)) => {
            let nothing = format!("nothing: only a {shape} with `displacement` has this key");
            Err(value.invalid(nothing))
        }
        (displacement, _) => displacement.map(|v| DisplacementEntry::read(&v)).transpose(),
    }
}

fn read_quad(table: &Table<'_>) -> Result<QuadEntry> {
    let corners = keys::CORNERS.located(table)?;
    let of_relief = [table.get(&keys::CLOSED), table.get(&METHOD_OF_SHAPE)];
    Ok(QuadEntry {
        corners,
        one_sided: keys::ONE_SIDED.of(table)?,
        displacement: read_displacement(table, ("quad", &of_relief))?,
        closed: keys::CLOSED.of(table)?,
        method: METHOD_OF_SHAPE.of(table)?,
        ground: None,
    })
}

fn read_sphere(table: &Table<'_>) -> Result<SphereEntry> {
    let (center, radius) = (keys::CENTER.of(table)?, keys::RADIUS.located(table)?);
    let of_relief = [table.get(&METHOD_OF_SHAPE)];
    Ok(SphereEntry {
        center,
        radius,
        displacement: read_displacement(table, ("sphere", &of_relief))?,
        method: METHOD_OF_SHAPE.of(table)?,
    })
}

fn read_mesh(table: &Table<'_>) -> Result<MeshEntry> {
    let file = keys::FILE.of(table)?;
    let (edges, matched) = keys::EDGES.of(table)?;
    let transform = table.get(&keys::TRANSFORM_TABLE);
    let transform = transform.map(|value| Ok((read_transform(&value)?, value.at()))).transpose()?;
    let of_relief =
        [table.get(&keys::CLOSED), table.get(&keys::MESH_ONE_SIDED), table.get(&METHOD_OF_SHAPE)];
    Ok(MeshEntry {
        file,
        projection: keys::PROJECTION.of(table)?,
        smooth: keys::SMOOTH.of(table)?,
        world_from_object: transform.map(|(value, at)| Located { value, at }),
        displacement: read_displacement(table, ("mesh", &of_relief))?,
        edges,
        matched,
        method: METHOD_OF_SHAPE.of(table)?,
        closed: keys::CLOSED.of(table)?,
        one_sided: keys::MESH_ONE_SIDED.of(table)?,
    })
}

/// Scaled first, then turned about x, y and z, then moved.
fn read_transform(value: &Value<'_>) -> Result<DAffine3> {
    let table = value.table()?;
    let transform = transform(&table)?;
    table.finish()?;
    Ok(transform)
}

/// The keys of a transform among those of a table.
pub(super) fn transform(table: &Table<'_>) -> Result<DAffine3> {
    let translate = DVec3::from_array(place::TRANSLATE.of(table)?);
    let [x, y, z] = place::ROTATE.of(table)?.map(f64::to_radians);
    let scale = place::SCALE.of(table)?;
    // Glam names rotations from the last one applied.
    let turn = DMat3::from_euler(EulerRot::ZYX, z, y, x);
    Ok(DAffine3::from_mat3_translation(turn * scale, translate))
}

impl DisplacementEntry {
    fn read(value: &Value<'_>) -> Result<Self> {
        let table = value.table()?;
        let map = keys::MAP.of(&table)?;
        let (scale, zero) = (keys::SCALE.of(&table)?, keys::ZERO.of(&table)?);
        let flat = Displacement::default();
        let displacement = Displacement {
            scale: scale.unwrap_or(flat.scale),
            zero: zero.unwrap_or(flat.zero),
            tile: keys::TILE.of(&table)?,
            shift: keys::SHIFT.of(&table)?,
        };
        let normals = Normals::read(&table)?;
        table.finish()?;
        let (scale_written, zero_written) = (scale.is_some(), zero.is_some());
        Ok(Self { map, displacement, scale_written, zero_written, normals, at: value.at() })
    }
}

impl Normals {
    fn read(table: &Table<'_>) -> Result<Self> {
        if let Some(value) = table.get(&keys::NORMALS_KIND)
            && value.is_table()
        {
            let table = value.table()?;
            let file = keys::NORMALS_FILE.of(&table)?;
            // Of a texture set it is measured.
            let convention = match table.get(&CONVENTION) {
                None if file.value.ends_with('/') => None,
                _ => Some(CONVENTION.of(&table)?),
            };
            table.finish()?;
            return Ok(Self::File { file, convention });
        }
        Ok(match keys::NORMALS_KIND.of(table)? {
            NormalsKind::Exact => Self::Exact,
            NormalsKind::Smooth => Self::Smooth,
            NormalsKind::Published => Self::Published,
            NormalsKind::WrongMetric => Self::WrongMetric,
        })
    }
}

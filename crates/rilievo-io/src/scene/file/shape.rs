//! `[[shapes]]`.

use std::ops::Range;

use rilievo::glam::{DAffine3, DMat3, DVec3, EulerRot};
use rilievo::map::NormalConvention;
use rilievo::relief::{Displacement, Edges, Method};

use super::super::syntax::{Located, Table, Value};
use super::instances::{InstanceEntry, read_instances};
use super::material::PAIR;
use super::terrain::{GroundEntry, read_terrain};
use super::texture::CONVENTIONS;
use super::view::{POINT, method, point};
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

/// The types of shapes.
#[derive(Clone, Copy)]
enum Kind {
    Quad,
    Sphere,
    Mesh,
    Terrain,
}

impl ShapeEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let kinds = [
            ("quad", Kind::Quad),
            ("sphere", Kind::Sphere),
            ("mesh", Kind::Mesh),
            ("terrain", Kind::Terrain),
        ];
        let kind = table.require("type")?.choice(&kinds)?;
        let material = table.get("material").map(|v| v.name()).transpose()?;
        let shape = match kind {
            Kind::Quad => Shape::Quad(read_quad(table)?),
            Kind::Sphere => Shape::Sphere(read_sphere(table)?),
            Kind::Mesh => Shape::Mesh(read_mesh(table)?),
            Kind::Terrain => Shape::Quad(read_terrain(table)?),
        };
        let instances = read_instances(table)?;
        table.finish()?;
        Ok(Self { shape, material, instances })
    }
}

fn read_quad(table: &Table<'_>) -> Result<QuadEntry> {
    let corners = table.require("corners")?.located(|value| {
        let mut corners = [DVec3::ZERO; 4];
        let allowed = "four corners: [[x, y, z], [x, y, z], [x, y, z], [x, y, z]]";
        for (slot, corner) in corners.iter_mut().zip(value.array::<4>(allowed)?) {
            *slot = point(&corner)?;
        }
        Ok(corners)
    })?;
    let one_sided = table.get("one_sided").map_or(Ok(false), |v| v.boolean())?;
    let displacement = table.get("displacement");
    let (closed, walked) = (table.get("closed"), table.get("method"));
    if displacement.is_none()
        && let Some(value) = closed.as_ref().or(walked.as_ref())
    {
        return Err(value.invalid("nothing: only a quad with `displacement` has this key"));
    }
    Ok(QuadEntry {
        corners,
        displacement: displacement.map(|v| DisplacementEntry::read(&v)).transpose()?,
        method: walked.map(|v| method(&v)).transpose()?,
        closed: closed.map_or(Ok(false), |v| v.boolean())?,
        one_sided,
        ground: None,
    })
}

fn read_sphere(table: &Table<'_>) -> Result<SphereEntry> {
    let center = point(&table.require("center")?)?;
    let radius = table.require("radius")?;
    let radius = radius.located(|v| v.number_in(f64::MIN_POSITIVE.., "a number above 0"))?;
    let (displacement, walked) = (table.get("displacement"), table.get("method"));
    if let (None, Some(value)) = (&displacement, &walked) {
        return Err(value.invalid("nothing: only a sphere with `displacement` has this key"));
    }
    Ok(SphereEntry {
        center,
        radius,
        displacement: displacement.map(|v| DisplacementEntry::read(&v)).transpose()?,
        method: walked.map(|v| method(&v)).transpose()?,
    })
}

fn read_mesh(table: &Table<'_>) -> Result<MeshEntry> {
    let file = table.require("file")?.name()?;
    let (edges, matched) = table.get("edges").map_or(Ok((Edges::Shared, false)), |v| {
        v.choice(&[
            ("shared", (Edges::Shared, false)),
            ("matched", (Edges::Shared, true)),
            ("as-authored", (Edges::AsAuthored, false)),
        ])
    })?;
    let transform = table.get("transform");
    let world_from_object = transform.map(|v| v.located(read_transform)).transpose()?;
    let displacement = table.get("displacement");
    let [closed, one_sided] = ["closed", "one_sided"].map(|key| table.get(key));
    let walked = table.get("method");
    if displacement.is_none()
        && let Some(value) = closed.as_ref().or(one_sided.as_ref()).or(walked.as_ref())
    {
        return Err(value.invalid("nothing: only a mesh with `displacement` has this key"));
    }
    let flag = |value: Option<Value<'_>>| value.map_or(Ok(false), |v| v.boolean());
    let projection = table.get("projection").map(|v| v.choice(&Projection::ALL)).transpose()?;
    Ok(MeshEntry {
        file,
        projection,
        smooth: flag(table.get("smooth"))?,
        world_from_object,
        displacement: displacement.map(|v| DisplacementEntry::read(&v)).transpose()?,
        edges,
        matched,
        method: walked.map(|v| method(&v)).transpose()?,
        closed: flag(closed)?,
        one_sided: flag(one_sided)?,
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
    let (translate, rotate) = (table.get("translate"), table.get("rotate"));
    let scale = table.get("scale");
    let translate = translate.map_or(Ok(DVec3::ZERO), |v| point(&v))?;
    let [x, y, z] = rotate.map_or(Ok([0.0; 3]), |v| v.numbers(POINT))?.map(f64::to_radians);
    let scale = scale.map_or(Ok(1.0), |v| match v.number()? {
        0.0 => Err(v.invalid("a number other than 0")),
        scale => Ok(scale),
    })?;
    // Glam names rotations from the last one applied.
    let turn = DMat3::from_euler(EulerRot::ZYX, z, y, x);
    Ok(DAffine3::from_mat3_translation(turn * scale, translate))
}

impl DisplacementEntry {
    fn read(value: &Value<'_>) -> Result<Self> {
        let table = value.table()?;
        let map = table.require("map")?.name()?;
        let mut displacement = Displacement::default();
        let (scale, zero) = (table.get("scale"), table.get("zero"));
        let (scale_written, zero_written) = (scale.is_some(), zero.is_some());
        if let Some(value) = scale {
            displacement.scale = match value.number()? {
                0.0 => return Err(value.invalid("a number other than 0")),
                scale => scale,
            };
        }
        if let Some(value) = zero {
            displacement.zero = value.number()?;
        }
        if let Some(value) = table.get("tile") {
            let allowed = "two numbers above 0: [along u, along v]";
            for (slot, value) in displacement.tile.iter_mut().zip(value.array::<2>(allowed)?) {
                *slot = value.number_in(f64::MIN_POSITIVE.., "a number above 0")?;
            }
        }
        if let Some(value) = table.get("shift") {
            displacement.shift = value.numbers(PAIR)?;
        }
        let normals = table.get("normals").map_or(Ok(Normals::Smooth), |v| Normals::read(&v))?;
        table.finish()?;
        let at = value.at();
        Ok(Self { map, displacement, scale_written, zero_written, normals, at })
    }
}

impl Normals {
    fn read(value: &Value<'_>) -> Result<Self> {
        /// The kinds that need no file.
        #[derive(Clone, Copy)]
        enum Kind {
            Exact,
            Smooth,
            Published,
            WrongMetric,
        }

        if value.is_table() {
            let table = value.table()?;
            let file = table.require("file")?.name()?;
            // Of a texture set it is measured.
            let convention = match file.value.ends_with('/') {
                true => table.get("convention"),
                false => Some(table.require("convention")?),
            };
            let convention = convention.map(|v| v.choice(&CONVENTIONS)).transpose()?;
            table.finish()?;
            return Ok(Self::File { file, convention });
        }
        let kind = value.choice(&[
            ("smooth", Kind::Smooth),
            ("exact", Kind::Exact),
            ("published", Kind::Published),
            ("wrong-metric", Kind::WrongMetric),
        ])?;
        Ok(match kind {
            Kind::Exact => Self::Exact,
            Kind::Smooth => Self::Smooth,
            Kind::Published => Self::Published,
            Kind::WrongMetric => Self::WrongMetric,
        })
    }
}

//! `[[shapes]]` and `displacement`.

use rilievo::glam::DVec3;
use rilievo::relief::Edges;

use super::kind::{Choice, Each, Flag, Form, Number, OrTable, Point, Points, Text, along_uv};
use super::render::METHOD_OF_SHAPE;
use super::{Fallback, Key, Optional, Required, Section, motion};
use crate::mesh::Projection;

/// The types of shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeKind {
    Quad,
    Sphere,
    Mesh,
    Terrain,
}

pub const TYPE: Key<Choice<ShapeKind>, Required> = Key::new(
    "type",
    Choice(|| {
        vec![
            ("quad", ShapeKind::Quad),
            ("sphere", ShapeKind::Sphere),
            ("mesh", ShapeKind::Mesh),
            ("terrain", ShapeKind::Terrain),
        ]
    }),
    Required(""),
    "what it is",
);
pub const MATERIAL: Key<Text, Optional> =
    Key::new("material", Text("name"), Optional("the defaults above"), "a name in `[materials]`");

/// Every shape.
pub const SHAPES: Section =
    Section { name: "shapes", table: "shapes[]", keys: &[&TYPE, &MATERIAL, &motion::OF_SHAPE] };

pub const CORNERS: Key<Points<4>, Required> = Key::new(
    "corners",
    Points("four corners: [[x, y, z], [x, y, z], [x, y, z], [x, y, z]]"),
    Required(""),
    "u runs from the first to the second, v from the first to the fourth",
)
.unit("scene units");
pub const ONE_SIDED: Key<Flag, Fallback<bool>> =
    Key::new("one_sided", Flag, Fallback(false), "`true`: rays from behind pass through");
pub const DISPLACEMENT_TABLE: Key<Form, Optional> =
    Key::new("displacement", Form("table"), Optional("none"), "the relief, see `displacement`");
pub const CLOSED: Key<Flag, Fallback<bool>> = Key::new(
    "closed",
    Flag,
    Fallback(false),
    "with `displacement`; `true`: walls from open borders down to offset 0",
);

/// `type = "quad"`.
pub const QUAD: Section = Section {
    name: "quad",
    table: "shapes[]",
    keys: &[&CORNERS, &ONE_SIDED, &DISPLACEMENT_TABLE, &CLOSED, &METHOD_OF_SHAPE],
};

pub const CENTER: Key<Point, Required> =
    Key::new("center", Point::Position, Required(""), "of the sphere").unit("scene units");
pub const RADIUS: Key<Number, Required> =
    Key::new("radius", Number::Above(0.0), Required(""), "of the sphere").unit("scene units");

/// `type = "sphere"`.
pub const SPHERE: Section = Section {
    name: "sphere",
    table: "shapes[]",
    keys: &[&CENTER, &RADIUS, &DISPLACEMENT_TABLE, &METHOD_OF_SHAPE],
};

pub const FILE: Key<Text, Required> = Key::new(
    "file",
    Text("path"),
    Required(""),
    "OBJ, PLY, glTF, GLB; without `material` those of its own are taken, without `displacement` as \
     well what they say of that, see [assets](ASSETS.md)",
);
pub const PROJECTION: Key<Choice<Projection>, Optional> = Key::new(
    "projection",
    Choice(|| Projection::ALL.into()),
    Optional("none"),
    "in place of the file's texture coordinates, see [assets](ASSETS.md)",
);
pub const SMOOTH: Key<Flag, Fallback<bool>> = Key::new(
    "smooth",
    Flag,
    Fallback(false),
    "`true`: faces without normals get angle-weighted ones",
);
/// Whose edges hold, and whether heights are matched along them.
type EdgeChoice = (Edges, bool);

pub const EDGES: Key<Choice<EdgeChoice>, Fallback<EdgeChoice>> = Key::new(
    "edges",
    Choice(|| {
        vec![
            ("shared", (Edges::Shared, false)),
            ("matched", (Edges::Shared, true)),
            ("as-authored", (Edges::AsAuthored, false)),
        ]
    }),
    Fallback((Edges::Shared, false)),
    "for `displacement`, see below",
);
pub const MESH_ONE_SIDED: Key<Flag, Fallback<bool>> = Key::new(
    "one_sided",
    Flag,
    Fallback(false),
    "with `displacement`; `true`: rays from behind pass through",
);
pub const TRANSFORM_TABLE: Key<Form, Optional> =
    Key::new("transform", Form("table"), Optional("none"), "where it stands, see below");

/// `type = "mesh"`.
pub const MESH: Section = Section {
    name: "mesh",
    table: "shapes[]",
    keys: &[
        &FILE,
        &PROJECTION,
        &SMOOTH,
        &DISPLACEMENT_TABLE,
        &EDGES,
        &CLOSED,
        &MESH_ONE_SIDED,
        &METHOD_OF_SHAPE,
        &TRANSFORM_TABLE,
    ],
};

pub const TERRAIN_MAP: Key<Text, Required> =
    Key::new("map", Text("name"), Required(""), "a name in `[maps]`");
pub const TERRAIN_CENTER: Key<Point, Fallback<DVec3>> =
    Key::new("center", Point::Position, Fallback(DVec3::ZERO), "where the middle of the map lies")
        .unit("scene units");
pub const UNIT: Key<Number, Fallback<f64>> =
    Key::new("unit", Number::Above(0.0), Fallback(1.0), "length of a scene unit").unit("metres");
pub const EXAGGERATION: Key<Number, Fallback<f64>> =
    Key::new("exaggeration", Number::Above(0.0), Fallback(1.0), "of heights");
pub const CELL: Key<Each<Number, 2>, Optional> = Key::new(
    "cell",
    along_uv(Number::Above(0.0)),
    Optional("of the file"),
    "from one sample to the next",
)
.unit("metres");
pub const TERRAIN_ZERO: Key<Number, Optional> =
    Key::new("zero", Number::Finite, Optional("the lowest"), "height at `center`").unit("metres");
pub const TERRAIN_CLOSED: Key<Flag, Fallback<bool>> = Key::new(
    "closed",
    Flag,
    Fallback(false),
    "`true`: walls from the border down to the lowest height",
);

/// `type = "terrain"`.
pub const TERRAIN: Section = Section {
    name: "terrain",
    table: "shapes[]",
    keys: &[
        &TERRAIN_MAP,
        &TERRAIN_CENTER,
        &UNIT,
        &EXAGGERATION,
        &CELL,
        &TERRAIN_ZERO,
        &METHOD_OF_SHAPE,
        &TERRAIN_CLOSED,
    ],
};

/// Which normals a displaced shape is shaded with, where no map gives them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormalsKind {
    Smooth,
    Exact,
    Published,
    WrongMetric,
}

pub const MAP: Key<Text, Required> = Key::new(
    "map",
    Text("name or folder"),
    Required(""),
    "a name in `[maps]`, or a texture set such as `\"rock/\"`",
);
pub const SCALE: Key<Number, Optional> = Key::new(
    "scale",
    Number::NotZero,
    Optional("1; a texture set's own"),
    "of a unit of height; negative turns the relief inside out",
)
.unit("scene units");
pub const ZERO: Key<Number, Optional> = Key::new(
    "zero",
    Number::Finite,
    Optional("0; of a texture set 0.5"),
    "height that stays in place",
);
pub const TILE: Key<Each<Number, 2>, Fallback<[f64; 2]>> =
    Key::new("tile", along_uv(Number::Above(0.0)), Fallback([1.0; 2]), "repetitions along u and v");
pub const SHIFT: Key<Each<Number, 2>, Fallback<[f64; 2]>> =
    Key::new("shift", along_uv(Number::Finite), Fallback([0.0; 2]), "along u and v")
        .unit("repetitions");
pub const NORMALS_KIND: Key<OrTable<Choice<NormalsKind>>, Fallback<NormalsKind>> = Key::new(
    "normals",
    OrTable(Choice(|| {
        vec![
            ("smooth", NormalsKind::Smooth),
            ("exact", NormalsKind::Exact),
            ("published", NormalsKind::Published),
            ("wrong-metric", NormalsKind::WrongMetric),
        ]
    })),
    Fallback(NormalsKind::Smooth),
    "to shade with, see below",
);

/// `displacement` of a shape.
pub const DISPLACEMENT: Section = Section {
    name: "displacement",
    table: "shapes[].displacement",
    keys: &[&MAP, &SCALE, &ZERO, &TILE, &SHIFT, &NORMALS_KIND],
};

pub const NORMALS_FILE: Key<Text, Required> =
    Key::new("file", Text("path"), Required(""), "an image of normals");

/// `normals` of a displacement.
pub const NORMALS: Section = Section {
    name: "normals",
    table: "shapes[].displacement.normals",
    keys: &[&NORMALS_FILE, &super::material::CONVENTION],
};

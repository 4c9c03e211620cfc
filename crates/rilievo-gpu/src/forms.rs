//! Forms: what the shaders of light ask of surfaces beside what those of rays do: normals, uv, tangents, and where points
//! are. The twins of each surface's `complete` (`shaders/hit`) read them. Everything is worked out in `f64` here, once.

mod mesh;

use std::collections::HashMap;
use std::sync::Arc;

use rilievo::glam::{DAffine3, DMat3, DVec2, DVec3};
use rilievo::map::{Axis, Metric};
use rilievo::mesh::Mesh;
use rilievo::relief::{ReliefFace, ReliefSphere, ShadingNormals};
use rilievo::surface::{Quad, Sphere, Surface, World};
use rilievo_render::device::{HEAD, NOTHING, SceneWords, Uncovered};

use crate::records::{self, Words};
pub(crate) use mesh::{SHELL_FORM, SHELL_WALL_FORM};

/// Words that are said of a surface.
pub(crate) const SURFACE_RECORD: u32 = 8;
/// Words of a triangle.
pub(crate) const TRIANGLE_FORM: usize = 37;
/// Words of a displaced face.
const FACE_FORM: usize = 65;

/// Triangles whose normals and uv are worth bringing over.
const MOST_TRIANGLES: usize = 1 << 22;

/// Appends forms and what is said of each surface to the words of a scene; `known` has the kind of each surface and its
/// first face, as the shaders of rays number them.
///
/// # Errors
/// [`Uncovered`] names a surface that the shaders of light do not know.
pub(crate) fn append(
    scene: &mut SceneWords,
    (world, anchor): (&World, DVec3),
    known: &[[u32; 2]],
) -> Result<(), Uncovered> {
    let mut shown: HashMap<usize, u32> = HashMap::new();
    let mut records = Vec::with_capacity(known.len() * SURFACE_RECORD as usize);
    let words = &mut scene.words;
    for ((surface, said), [kind, face]) in world.surfaces().iter().zip(&scene.surfaces).zip(known) {
        let mut shown = |words: &mut Vec<u32>, prototype: &Arc<Surface>| {
            let bounds = prototype.bounds();
            let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.centre() };
            let address = Arc::as_ptr(prototype).addr();
            let form = match shown.get(&address) {
                Some(form) => *form,
                None => write_form(words, prototype, middle)?,
            };
            shown.insert(address, form);
            Ok((form, middle))
        };
        let (form, transform, moves) = match surface {
            Surface::Instance(instance) => {
                let (form, middle) = shown(words, instance.prototype())?;
                let place = instance.world_from_local();
                (form, write_transform(words, place, [anchor, middle]), 0)
            }
            Surface::Moving(moving) => {
                let (form, middle) = shown(words, moving.prototype())?;
                let (begin, motion) = (moving.world_from_local(0.0), moving.motion());
                let transform = write_transform(words, &begin, [motion.pivot, middle]);
                records::write_motion(words, motion, anchor);
                (form, transform, 1)
            }
            other => (write_form(words, other, anchor)?, NOTHING, 0),
        };
        let drawn = said.drawn.unwrap_or(NOTHING);
        let glows = u32::from(said.is_light);
        records.extend([said.material, form, glows, *kind, *face, drawn, transform, moves]);
    }
    if let Some(at) = HEAD.iter().position(|name| *name == "FIRST_SURFACE") {
        words[at] = words.len() as u32;
    }
    words.extend(records);
    Ok(())
}

/// Writes the form of a surface that is no instance; returns its place.
fn write_form(words: &mut Vec<u32>, surface: &Surface, anchor: DVec3) -> Result<u32, Uncovered> {
    let place = words.len() as u32;
    match surface {
        Surface::Face(face) => write_face(words, face, anchor)?,
        Surface::Quad(quad) => write_quad(words, quad, anchor),
        Surface::Sphere(sphere) => write_sphere(words, sphere, anchor),
        Surface::Mesh(mesh) => write_mesh(words, mesh, anchor)?,
        Surface::ReliefSphere(sphere) => write_relief_sphere(words, sphere, anchor)?,
        Surface::ReliefMesh(mesh) => mesh::write_relief_mesh(words, mesh, anchor)?,
        Surface::Instance(_) | Surface::Moving(_) => {
            return Err(Uncovered("an instance of an instance"));
        }
    }
    Ok(place)
}

/// The way to the frame of a prototype, and back.
fn write_transform(
    words: &mut Vec<u32>,
    world_from_local: &DAffine3,
    [anchor, middle]: [DVec3; 2],
) -> u32 {
    let place = words.len() as u32;
    let local_from_world = world_from_local.inverse();
    for (map, [from, to]) in
        [(local_from_world, [anchor, middle]), (*world_from_local, [middle, anchor])]
    {
        let DMat3 { x_axis, y_axis, z_axis } = map.matrix3.transpose();
        [x_axis, y_axis, z_axis, map.matrix3 * from + map.translation - to]
            .into_iter()
            .for_each(|row| words.vector(row));
    }
    place
}

fn triple(words: &mut Vec<u32>, v: DVec3) {
    v.to_array().into_iter().for_each(|x| words.float(x as f32));
}

fn pair(words: &mut Vec<u32>, v: DVec2) {
    v.to_array().into_iter().for_each(|x| words.float(x as f32));
}

/// Factor and offset that make a parameter of a coordinate.
fn along_uv(axis: &Axis) -> [f64; 2] {
    let [first, second] = [0.0, 1.0].map(|x| axis.parameter(x));
    [second - first, first]
}

/// A displaced face; the twin of `MapAxes::new` and `Placement`.
fn write_face(words: &mut Vec<u32>, face: &ReliefFace, anchor: DVec3) -> Result<(), Uncovered> {
    let before = words.len();
    let [corner, edge_u, edge_v, normal] = face.frame();
    let (heights, options) = (face.relief().heights(), face.options());
    let d = options.displacement;
    let axes = [heights.x(), heights.y()].map(along_uv);
    let scale = [0, 1].map(|k| axes[k][0] / d.tile[k]);
    let shift = [0, 1].map(|k| (axes[k][1] - d.shift[k]) / d.tile[k]);
    // Where lattice coordinates and the raw height are 0, and what one of each adds.
    words.vector(
        corner - anchor + shift[0] * edge_u + shift[1] * edge_v - d.scale * d.zero * normal,
    );
    words.vector(scale[0] * edge_u);
    words.vector(scale[1] * edge_v);
    words.vector(d.scale * heights.unit() * normal);
    let (length_u, length_v) = (edge_u.length(), edge_v.length());
    let area = edge_u.cross(edge_v).length();
    [-length_u * normal.cross(edge_v), -length_v * edge_u.cross(normal), edge_u.cross(edge_v)]
        .into_iter()
        .for_each(|column| triple(words, column / area));
    let own = Metric::of_face(heights, [length_u / d.tile[0], length_v / d.tile[1]], d.scale);
    let (kind, metric) = match options.normals {
        ShadingNormals::Exact => (0, own),
        ShadingNormals::Smooth => (1, own),
        ShadingNormals::Published => (2, own),
        ShadingNormals::WrongMetric => (1, Metric::of_face(heights, [1.0; 2], 1.0)),
        ShadingNormals::Map(_) => return Err(Uncovered("a map of normals under a relief")),
    };
    for Metric { x, y, z } in [own, metric] {
        [z / x, z / y].into_iter().for_each(|steepness| words.float(steepness as f32));
    }
    words.push(kind);
    pair(words, scale.into());
    pair(words, shift.into());
    words.extend([0; 2]);
    triple(words, edge_u);
    triple(words, edge_v);
    [edge_v, edge_u].into_iter().for_each(|edge| triple(words, edge.cross(normal).normalize()));
    let across = edge_u.cross(edge_v);
    let squared = across.length_squared();
    triple(words, corner - anchor);
    triple(words, edge_v.cross(across) / squared);
    triple(words, across.cross(edge_u) / squared);
    debug_assert_eq!(words.len() - before, FACE_FORM);
    Ok(())
}

fn write_sphere(words: &mut Vec<u32>, sphere: &Sphere, anchor: DVec3) {
    words.vector(sphere.center() - anchor);
    words.double(sphere.radius());
}

fn write_relief_sphere(
    words: &mut Vec<u32>,
    sphere: &ReliefSphere,
    anchor: DVec3,
) -> Result<(), Uncovered> {
    let frame = sphere.frame();
    let smooth = match sphere.options().normals {
        ShadingNormals::Smooth => 1,
        ShadingNormals::Map(_) => return Err(Uncovered("a map of normals under a relief")),
        _ => 0,
    };
    words.vector(sphere.center() - anchor);
    words.double(frame.at_zero);
    words.double(frame.per_raw);
    words.extend([sphere.relief().cells(), smooth]);
    words.float(sphere.radius() as f32);
    Ok(())
}

/// Corners, unit normal, what mixes to a shading normal, and uv.
struct Form {
    corners: [DVec3; 3],
    normal: DVec3,
    normals: Option<[DVec3; 3]>,
    uvs: [DVec2; 3],
    /// Whether uv are held to the unit square.
    held: bool,
}

/// Uv of the second and third corner count from the first where there are none.
const WEIGHTS: [DVec2; 3] = [DVec2::ZERO, DVec2::X, DVec2::Y];

fn write_quad(words: &mut Vec<u32>, quad: &Quad, anchor: DVec3) {
    let [c0, c1, c2, c3] = quad.corners();
    words.push(2);
    let halves = [
        ([c0, c1, c2], [DVec2::ZERO, DVec2::X, DVec2::ONE]),
        ([c0, c2, c3], [DVec2::ZERO, DVec2::ONE, DVec2::Y]),
    ];
    for (corners, uvs) in halves {
        let [a, b, c] = if quad.is_parallelogram() { [c0, c1, c3] } else { corners };
        let normal = (b - a).cross(c - a).normalize_or_zero();
        write_triangle(words, &Form { corners, normal, normals: None, uvs, held: true }, anchor);
    }
}

fn write_mesh(words: &mut Vec<u32>, mesh: &Mesh, anchor: DVec3) -> Result<(), Uncovered> {
    let data = mesh.data();
    if data.triangles.len() > MOST_TRIANGLES {
        return Err(Uncovered("a mesh of more than four million triangles"));
    }
    words.push(data.triangles.len() as u32);
    for (k, triangle) in (0..).zip(&data.triangles) {
        let corners = mesh.corners(k);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
        let normals = triangle.normals.map(|at| at.map(|n| data.normals[n as usize]));
        let uvs = triangle.uvs.map_or(WEIGHTS, |at| at.map(|uv| data.uvs[uv as usize]));
        write_triangle(words, &Form { corners, normal, normals, uvs, held: false }, anchor);
    }
    Ok(())
}

fn write_triangle(words: &mut Vec<u32>, form: &Form, anchor: DVec3) {
    let before = words.len();
    let [a, b, c] = form.corners;
    let (e, f) = (b - a, c - a);
    let across = e.cross(f);
    let squared = across.length_squared().max(f64::MIN_POSITIVE);
    words.vector(a - anchor);
    for v in [e, f, f.cross(across) / squared, across.cross(e) / squared, form.normal] {
        triple(words, v);
    }
    form.normals.unwrap_or_default().into_iter().for_each(|n| triple(words, n));
    let [uv, g, h] = form.uvs;
    [uv, g - uv, h - uv].into_iter().for_each(|uv| pair(words, uv));
    words.push(u32::from(form.normals.is_some()) + 2 * u32::from(form.held));
    debug_assert_eq!(words.len() - before, TRIANGLE_FORM);
}

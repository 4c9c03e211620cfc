//! Nodes, scenes, cameras and lights: what stands where.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::json::Json;
use super::primitive::Primitive;
use crate::error::Result;
use crate::mesh::{LightKind, ModelCamera, ModelLight};

/// Properties that together stand in place of `matrix`.
const PARTS: [&str; 3] = ["translation", "rotation", "scale"];
/// How far a quaternion may be from a unit one, and a matrix from one of right angles.
const UNIT: f64 = 1e-2;
/// The extension of lights.
const LIGHTS: &str = "KHR_lights_punctual";

/// A node: where it is in its parent, and what it holds.
pub(super) struct Node {
    parent_from_node: DAffine3,
    children: Vec<usize>,
    pub mesh: Option<usize>,
    pub camera: Option<usize>,
    pub light: Option<usize>,
    has_parent: bool,
}

/// The nodes of a document, and where its scene begins.
pub(super) struct Nodes {
    pub all: Vec<Node>,
    roots: Vec<usize>,
}

impl Nodes {
    /// Reads nodes and scenes.
    pub fn read(root: &Json<'_>, meshes: &[Vec<Primitive>]) -> Result<Self> {
        let list = root.objects("nodes")?;
        let mut all = list
            .iter()
            .map(|json| node(json, root, meshes, list.len()))
            .collect::<Result<Vec<_>>>()?;
        for k in 0..all.len() {
            for child in all[k].children.clone() {
                if std::mem::replace(&mut all[child].has_parent, true) {
                    let found = format!("node {child} has a parent already");
                    return Err(list[k].fault("children", found, "one parent for a node"));
                }
            }
        }
        // With one parent each, what no root reaches runs in a circle.
        let mut reached = vec![false; all.len()];
        let mut stack: Vec<usize> = (0..all.len()).filter(|&k| !all[k].has_parent).collect();
        let parentless = stack.clone();
        while let Some(k) = stack.pop() {
            reached[k] = true;
            stack.extend(&all[k].children);
        }
        if let Some(k) = reached.iter().position(|reached| !reached) {
            return Err(list[k].fault("children", "a circle", "a tree"));
        }
        let scenes = root.objects("scenes")?;
        let mut first = None;
        for scene in &scenes {
            let nodes = scene.list("nodes")?;
            let nodes: Vec<usize> =
                nodes.iter().map(|json| json.index(all.len())).collect::<Result<_>>()?;
            if let Some(k) = nodes.iter().find(|&&k| all[k].has_parent) {
                return Err(scene.fault("nodes", format!("node {k}, which has a parent"), "roots"));
            }
            let wanted = root.index_of("scene", scenes.len())?.unwrap_or(0);
            if scene.pointer.ends_with(&format!("/{wanted}")) {
                first = Some(nodes);
            }
        }
        if scenes.is_empty() {
            root.index_of("scene", 0)?;
        }
        Ok(Self { all, roots: first.unwrap_or(parentless) })
    }

    /// Calls `visit` for every node of the scene with its place in the world.
    pub fn walk(&self, mut visit: impl FnMut(&Node, DAffine3) -> Result<()>) -> Result<()> {
        let mut stack: Vec<_> = self.roots.iter().rev().map(|&k| (k, DAffine3::IDENTITY)).collect();
        while let Some((k, world_from_parent)) = stack.pop() {
            let node = &self.all[k];
            let world_from_node = world_from_parent * node.parent_from_node;
            visit(node, world_from_node)?;
            stack.extend(node.children.iter().rev().map(|&child| (child, world_from_node)));
        }
        Ok(())
    }
}

fn node(json: &Json<'_>, root: &Json<'_>, meshes: &[Vec<Primitive>], nodes: usize) -> Result<Node> {
    let count = |key| root.list(key).map(|list| list.len());
    let mesh = json.index_of("mesh", meshes.len())?;
    let skin = json.index_of("skin", count("skins")?)?;
    let primitives = mesh.map_or(&[][..], |mesh| &meshes[mesh]);
    if skin.is_some() && !primitives.iter().all(|p| p.skinned) {
        return Err(json.fault("skin", "of a mesh without joints", "a mesh with JOINTS_0"));
    }
    for key in ["skin", "weights"] {
        if mesh.is_none() && json.get(key).is_some() {
            return Err(json.fault(key, "without a mesh", "a mesh beside it"));
        }
    }
    let weights = json.list("weights")?;
    let targets = primitives.first().map_or(0, |p| p.targets);
    if json.get("weights").is_some() && weights.len() != targets {
        let found = format!("{} numbers", weights.len());
        return Err(json.fault("weights", found, format!("{targets}, one a morph target")));
    }
    let children = json.list("children")?;
    let children = children.iter().map(|child| child.index(nodes)).collect::<Result<_>>()?;
    let lights = match root.extension(LIGHTS) {
        Some(extension) => extension.list("lights")?.len(),
        None => 0,
    };
    let light = match json.extension(LIGHTS) {
        Some(extension) => Some(extension.require("light")?.index(lights)?),
        None => None,
    };
    Ok(Node {
        parent_from_node: transform(json)?,
        children,
        mesh,
        camera: json.index_of("camera", count("cameras")?)?,
        light,
        has_parent: false,
    })
}

/// Where a node is in its parent.
fn transform(json: &Json<'_>) -> Result<DAffine3> {
    let [x, y, z] = json.numbers_or("translation", [0.0; 3])?;
    let rotation = json.numbers_or::<4>("rotation", [0.0, 0.0, 0.0, 1.0])?;
    let scale = json.numbers_or("scale", [1.0; 3])?;
    let turn = DQuat::from_array(rotation);
    if (turn.length() - 1.0).abs() > UNIT {
        return Err(json.fault("rotation", format!("{rotation:?}"), "a unit quaternion"));
    }
    let Some(matrix) = json.get("matrix") else {
        let (turn, at) = (turn.normalize(), DVec3::new(x, y, z));
        return Ok(DAffine3::from_scale_rotation_translation(scale.into(), turn, at));
    };
    if PARTS.iter().any(|part| json.get(part).is_some()) {
        let allowed = "either a matrix or translation, rotation and scale";
        return Err(json.fault("matrix", "beside other transforms", allowed));
    }
    let m: [f64; 16] = matrix.numbers()?;
    let column = |k: usize| DVec3::new(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
    let columns = [0, 1, 2].map(column);
    let flat = [m[3], m[7], m[11], m[15]] == [0.0, 0.0, 0.0, 1.0];
    let square = [(0, 1), (0, 2), (1, 2)].iter().all(|&(a, b)| {
        let (a, b): (DVec3, DVec3) = (columns[a], columns[b]);
        a.dot(b).abs() <= UNIT * a.length() * b.length()
    });
    if !flat || !square {
        let allowed = "a matrix of translation, rotation and scale";
        return Err(matrix.fault("matrix", format!("{m:?}"), allowed));
    }
    let [x, y, z] = columns;
    Ok(DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), column(3)))
}

/// The perspective camera `json`, placed; none for another kind.
pub(super) fn camera(json: &Json<'_>, world_from_node: DAffine3) -> Result<Option<ModelCamera>> {
    let Some(perspective) = json.get("perspective") else { return Ok(None) };
    let fov = perspective.require("yfov")?.number()?.to_degrees();
    if !(fov > 0.0 && fov < 180.0) {
        return Err(perspective.fault("yfov", format!("{fov} degrees"), "above 0, below pi"));
    }
    let aspect = perspective.get("aspectRatio").map(|value| value.number()).transpose()?;
    let along = |v: DVec3| world_from_node.transform_vector3(v).normalize_or(v);
    Ok(Some(ModelCamera {
        name: json.text_of("name")?.unwrap_or_default().to_owned(),
        position: world_from_node.translation,
        forward: along(-DVec3::Z),
        up: along(DVec3::Y),
        fov,
        aspect: aspect.filter(|aspect| *aspect > 0.0),
    }))
}

/// Light `index` of the document, placed.
pub(super) fn light(
    root: &Json<'_>,
    index: usize,
    world_from_node: DAffine3,
) -> Result<Option<ModelLight>> {
    let Some(extension) = root.extension(LIGHTS) else { return Ok(None) };
    let lights = extension.objects("lights")?;
    let Some(json) = lights.get(index) else { return Ok(None) };
    let position = world_from_node.translation;
    let direction = world_from_node.transform_vector3(-DVec3::Z).normalize_or(-DVec3::Z);
    let kind = match json.require("type")?.text()? {
        "point" => LightKind::Point { position },
        "directional" => LightKind::Sun { direction },
        "spot" => {
            let (inner, outer) = match json.get("spot") {
                Some(spot) => {
                    let outer = spot.number_or("outerConeAngle", std::f64::consts::FRAC_PI_4)?;
                    (spot.number_or("innerConeAngle", 0.0)?, outer)
                }
                None => (0.0, std::f64::consts::FRAC_PI_4),
            };
            LightKind::Spot { position, direction, inner, outer }
        }
        other => {
            return Err(json.fault("type", format!("{other:?}"), "point, directional, spot"));
        }
    };
    let colour = DVec3::from_array(json.numbers_or("color", [1.0; 3])?);
    let intensity = colour * json.number_or("intensity", 1.0)?;
    if intensity.min_element() < 0.0 {
        return Err(json.fault("intensity", format!("{intensity}"), "at least 0"));
    }
    let name = json.text_of("name")?.unwrap_or_default().to_owned();
    Ok(Some(ModelLight { name, intensity, kind }))
}

//! Primitives: attributes and indices, checked, and the triangles they make.

use glam::{DVec2, DVec3};

use super::accessor::{Accessor, Component, Shape};
use super::buffers::{Buffers, Usage};
use super::json::Json;
use crate::error::Result;
use crate::limits::Limits;

/// `mode` of triangles, strips and fans.
const TRIANGLES: u64 = 4;
const STRIP: u64 = 5;
const FAN: u64 = 6;

/// A primitive whose references hold.
pub(super) struct Primitive {
    mode: u64,
    positions: Option<usize>,
    normals: Option<usize>,
    /// Accessors of TEXCOORD_0, TEXCOORD_1 and so on.
    pub uvs: Vec<usize>,
    indices: Option<usize>,
    pub material: Option<usize>,
    pub skinned: bool,
    /// Number of morph targets.
    pub targets: usize,
    pub json_pointer: String,
}

/// Decoded triangles of a primitive, in its own frame.
pub(super) struct Triangles {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub uvs: Vec<DVec2>,
    pub corners: Vec<[u32; 3]>,
}

/// Names of attributes that are numbered from 0, and the components they may have.
const NUMBERED: [&str; 4] = ["TEXCOORD", "COLOR", "JOINTS", "WEIGHTS"];

/// The set an attribute belongs to and its number: `TEXCOORD_1` is (`TEXCOORD`, 1).
fn semantic(name: &str) -> Option<(&str, Option<u64>)> {
    if let "POSITION" | "NORMAL" | "TANGENT" = name {
        return Some((name, None));
    }
    // Names of applications begin with an underscore.
    if name.starts_with('_') {
        return Some((name, None));
    }
    let (set, number) = name.split_once('_')?;
    let plain = number == "0" || !number.starts_with('0');
    let digits = plain && !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
    let known = NUMBERED.contains(&set) && digits;
    known.then(|| Some((set, Some(number.parse().ok()?)))).flatten()
}

/// Whether an attribute may have this format.
fn is_format(set: &str, format: (Shape, Component), normalized: bool, morph: bool) -> bool {
    use Component::{F32, I8, I16, U8, U16};
    let (shape, component) = format;
    let small = normalized && matches!(component, U8 | U16);
    let signed = normalized && matches!(component, I8 | I16);
    match set {
        "POSITION" | "NORMAL" => shape == Shape::Vec3 && component == F32,
        "TANGENT" => shape == (if morph { Shape::Vec3 } else { Shape::Vec4 }) && component == F32,
        "TEXCOORD" => shape == Shape::Vec2 && (component == F32 || small || (morph && signed)),
        "COLOR" => {
            let four = matches!(shape, Shape::Vec3 | Shape::Vec4);
            four && (component == F32 || small || (morph && signed))
        }
        "JOINTS" => shape == Shape::Vec4 && matches!(component, U8 | U16),
        "WEIGHTS" => shape == Shape::Vec4 && (component == F32 || small),
        _ => true,
    }
}

/// What the primitives of a document are checked against.
pub(super) struct Context<'c, 'a, 'b> {
    pub accessors: &'c [Accessor<'a>],
    pub buffers: &'c mut Buffers<'b>,
    pub materials: usize,
    /// Whether KHR_mesh_quantization allows more formats.
    pub quantized: bool,
}

impl Primitive {
    /// Reads and checks a primitive.
    pub fn read(json: &Json<'_>, context: &mut Context<'_, '_, '_>) -> Result<Self> {
        let mode = json.whole_or("mode", TRIANGLES)?;
        if mode > FAN {
            return Err(json.fault("mode", mode.to_string(), "0 to 6"));
        }
        let attributes = not_empty(json.require("attributes")?.object()?)?;
        let all = context.accessors.len();
        let mut primitive = Self {
            mode,
            positions: attributes.index_of("POSITION", all)?,
            normals: attributes.index_of("NORMAL", all)?,
            uvs: Vec::new(),
            indices: json.index_of("indices", all)?,
            material: json.index_of("material", context.materials)?,
            skinned: attributes.get("JOINTS_0").is_some(),
            targets: 0,
            json_pointer: json.pointer.clone(),
        };
        let count = primitive.check_attributes(&attributes, context)?;
        primitive.check_indices(json, context)?;
        for target in json.objects("targets")? {
            primitive.targets += 1;
            check_target(&not_empty(target)?, &attributes, count, context)?;
        }
        Ok(primitive)
    }

    /// Checks the attributes; gives the number of vertices.
    fn check_attributes(
        &mut self,
        attributes: &Json<'_>,
        context: &mut Context<'_, '_, '_>,
    ) -> Result<u64> {
        let (mut count, mut sets) = (None, [0_u64; NUMBERED.len()]);
        let mut highest = sets;
        for (name, json) in attributes.properties() {
            let accessor = check_attribute(name, &json, context, false)?;
            if let Some((set, Some(number))) = semantic(name)
                && let Some(k) = NUMBERED.iter().position(|n| *n == set)
            {
                sets[k] += 1;
                highest[k] = highest[k].max(number + 1);
            }
            let found = context.accessors[accessor].count;
            if *count.get_or_insert(found) != found {
                let allowed = "as many elements as the other attributes";
                return Err(json.fault("attribute", format!("{found} elements"), allowed));
            }
        }
        if let Some(k) = (0..sets.len()).find(|&k| sets[k] != highest[k]) {
            let found = format!("{} sets of {}", sets[k], NUMBERED[k]);
            return Err(attributes.fault("attributes", found, "numbered from 0 without gaps"));
        }
        if sets[2] != sets[3] {
            let found = format!("{} JOINTS, {} WEIGHTS", sets[2], sets[3]);
            return Err(attributes.fault("attributes", found, "as many of both"));
        }
        for number in 0..sets[0] {
            let accessor =
                attributes.index_of(&format!("TEXCOORD_{number}"), context.accessors.len());
            self.uvs.extend(accessor?);
        }
        Ok(count.unwrap_or(0))
    }

    fn check_indices(&self, json: &Json<'_>, context: &mut Context<'_, '_, '_>) -> Result<()> {
        let (Some(index), Some(json)) = (self.indices, json.get("indices")) else { return Ok(()) };
        let accessor = &context.accessors[index];
        if let Some(view) = accessor.view {
            context.buffers.mark(view, Usage::Indices, &json)?;
        }
        use Component::{U8, U16, U32};
        match accessor.format {
            Some((Shape::Scalar, U8 | U16 | U32)) if !accessor.normalized => Ok(()),
            found => {
                let found = format!("{found:?}");
                Err(json.fault("indices", found, "SCALAR of unsigned integers, not normalized"))
            }
        }
    }

    /// The triangles; none for points, lines, and a primitive without positions.
    pub fn triangles(
        &self,
        (accessors, buffers): (&[Accessor<'_>], &Buffers<'_>),
        uv_set: usize,
        limits: &Limits,
    ) -> Result<Option<Triangles>> {
        let (Some(positions), true) = (self.positions, self.mode >= TRIANGLES) else {
            return Ok(None);
        };
        let finite = |accessor: usize, what: &str| -> Result<Vec<DVec3>> {
            let accessor = &accessors[accessor];
            let all = accessor.elements::<3>(buffers, limits)?;
            match all.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
                None => Ok(all.into_iter().map(DVec3::from_array).collect()),
                Some(k) => {
                    let found = format!("element {k} is {:?}", all[k]);
                    Err(accessor.json.fault(what, found, "finite numbers"))
                }
            }
        };
        let positions = finite(positions, "position")?;
        let normals = self.normals.map_or(Ok(Vec::new()), |accessor| finite(accessor, "normal"))?;
        let mut uvs = Vec::new();
        if let Some(&accessor) = self.uvs.get(uv_set) {
            let all = accessors[accessor].elements::<2>(buffers, limits)?;
            if let Some(k) = all.iter().position(|uv| uv.iter().any(|c| !c.is_finite())) {
                let found = format!("element {k} is {:?}", all[k]);
                return Err(accessors[accessor].json.fault("uv", found, "finite numbers"));
            }
            // Here v runs down the image.
            uvs.extend(all.into_iter().map(|[u, v]| DVec2::new(u, 1.0 - v)));
        }
        let order: Vec<u32> = match self.indices {
            Some(accessor) => {
                let accessor = &accessors[accessor];
                let all = accessor.elements::<1>(buffers, limits)?;
                if let Some([index]) = all.iter().find(|[i]| *i >= positions.len() as f64) {
                    let allowed = format!("below {}, the number of vertices", positions.len());
                    return Err(accessor.json.fault("index", index.to_string(), allowed));
                }
                all.into_iter().map(|[i]| i as u32).collect()
            }
            None => (0..positions.len() as u32).collect(),
        };
        let corners = match self.mode {
            STRIP => (order.windows(3).enumerate())
                .map(|(k, t)| if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] })
                .collect(),
            FAN => order.windows(2).skip(1).map(|t| [order[0], t[0], t[1]]).collect(),
            _ => order.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        };
        Ok(Some(Triangles { positions, normals, uvs, corners }))
    }
}

fn not_empty(json: Json<'_>) -> Result<Json<'_>> {
    let filled = json.properties().next().is_some();
    match filled {
        true => Ok(json),
        false => Err(json.fault("object", "empty", "at least one attribute")),
    }
}

/// Checks one attribute of a primitive or morph target; gives its accessor.
fn check_attribute(
    name: &str,
    json: &Json<'_>,
    context: &mut Context<'_, '_, '_>,
    morph: bool,
) -> Result<usize> {
    let Some((set, _)) = semantic(name) else {
        let allowed = "POSITION, NORMAL, TANGENT, TEXCOORD_n, COLOR_n, JOINTS_n, WEIGHTS_n, _NAME";
        return Err(json.fault("attribute", format!("{name:?}"), allowed));
    };
    let index = json.index(context.accessors.len())?;
    let accessor = &context.accessors[index];
    if let Some(view) = accessor.view {
        context.buffers.mark(view, Usage::Vertices, json)?;
        let view = &mut context.buffers.views[view];
        if !view.attributes.contains(&index) && view.attributes.len() < 2 {
            view.attributes.push(index);
        }
        if view.attributes.len() > 1 && view.stride.is_none() {
            let found = "a view of two attributes without byteStride";
            return Err(json.fault("attribute", found, "byteStride, or a view for each"));
        }
        let step = view.stride.unwrap_or(accessor.element_bytes());
        if ![accessor.offset, view.offset, step].iter().all(|at| at.is_multiple_of(4)) {
            let found = "elements that do not begin at multiples of 4 bytes";
            return Err(json.fault("attribute", found, "aligned elements"));
        }
    }
    let allowed = "a format that glTF allows for this attribute";
    if let Some((_, Component::U32)) = accessor.format {
        return Err(json.fault("attribute", "32-bit integers", allowed));
    }
    if let Some(format) = accessor.format
        && !context.quantized
        && !is_format(set, format, accessor.normalized, morph)
    {
        return Err(json.fault("attribute", format!("{format:?}"), allowed));
    }
    if set == "POSITION" && !accessor.bounded {
        return Err(json.fault("POSITION", "an accessor without min and max", "both"));
    }
    Ok(index)
}

fn check_target(
    target: &Json<'_>,
    attributes: &Json<'_>,
    count: u64,
    context: &mut Context<'_, '_, '_>,
) -> Result<()> {
    for (name, json) in target.properties() {
        let accessor = check_attribute(name, &json, context, true)?;
        if attributes.get(name).is_none() {
            return Err(json.fault(
                "morph target",
                format!("{name:?}"),
                "attributes of the primitive",
            ));
        }
        let found = context.accessors[accessor].count;
        if found != count {
            return Err(json.fault("morph target", format!("{found} elements"), count.to_string()));
        }
    }
    Ok(())
}

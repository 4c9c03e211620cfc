//! MaterialX: which image of a document is which map, and how deep its displacement is.
//!
//! Read is the part that asset libraries write \[Smythe2019\]: a surface shader (`standard_surface`,
//! `open_pbr_surface`, `gltf_pbr`, `UsdPreviewSurface`) and a `displacement`, whose inputs lead through
//! node graphs to `image` or `tiledimage`. On the way of the displacement stand arithmetic nodes with
//! constants: `add`, `subtract`, `multiply`, `divide`, `invert`, `remap`, `range`, so that the offset is
//! `gain * H + base`; everything else is passed through where it has one input, or ends the search.
//! `scale` of `displacement` is in scene units.

mod graph;

use std::path::{Path, PathBuf};

use roxmltree::{Document, Node, ParsingOptions};

use super::MapRole;
use crate::error::{Error, Excerpt, Place, Result};
use crate::limits::Limits;
use graph::{Graph, Source};

/// Most nodes of a document.
const MAX_NODES: u32 = 1 << 16;
/// Bytes of memory that a byte of XML may become.
const GROWTH: u64 = 32;

/// Inputs of surface shaders by the map they want.
const INPUTS: [(&str, MapRole); 14] = [
    ("base_color", MapRole::Albedo),
    ("diffuse_color", MapRole::Albedo),
    ("diffuseColor", MapRole::Albedo),
    ("specular_roughness", MapRole::Roughness),
    ("roughness", MapRole::Roughness),
    ("metalness", MapRole::Metalness),
    ("base_metalness", MapRole::Metalness),
    ("metallic", MapRole::Metalness),
    ("normal", MapRole::Normal),
    ("geometry_normal", MapRole::Normal),
    ("emission_color", MapRole::Emission),
    ("emissiveColor", MapRole::Emission),
    ("opacity", MapRole::Opacity),
    ("occlusion", MapRole::Occlusion),
];

/// What a MaterialX document says of its maps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialX {
    /// Images by what they are for; of paths, relative ones start at the document's folder.
    pub images: Vec<(MapRole, PathBuf)>,
    /// How the displacement is meant, if there is one that leads to an image.
    pub displacement: Option<WrittenDisplacement>,
}

/// A displacement of `scale * (H - zero)` scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrittenDisplacement {
    /// Scene units per unit of height, not 0.
    pub scale: f64,
    /// The height that stays in place.
    pub zero: f64,
}

impl MaterialX {
    /// Reads a document.
    ///
    /// # Errors
    /// Of the file or its size; text that is not XML; numbers that are none.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        Self::read_bytes(&limits.read(path)?, path, limits)
    }

    /// Reads a document from bytes; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`MaterialX::read`].
    pub fn read_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Self> {
        limits.check(name, Place::File, "reading XML", &[bytes.len() as u64, GROWTH])?;
        let invalid = |place, what: &str, found: String, allowed: &str| {
            Error::invalid(name, place, what, found, allowed)
        };
        let text = std::str::from_utf8(bytes)
            .map_err(|e| invalid(Place::File, "text", e.to_string(), "UTF-8"))?;
        let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options).map_err(|e| {
            let at = line_start(text, e.pos().row) + e.pos().col.saturating_sub(1) as usize;
            let place = Place::Text(Excerpt::new(text, at..at + 1));
            invalid(place, "syntax", e.to_string(), "XML")
        })?;
        let root = document.root_element();
        if root.tag_name().name() != "materialx" {
            let found = root.tag_name().name().to_owned();
            return Err(invalid(Place::File, "root element", found, "materialx"));
        }
        Self::of_root(&Graph::new(name, text, root))
    }

    fn of_root(graph: &Graph<'_, '_>) -> Result<Self> {
        let mut found = Self::default();
        let root = graph.root();
        let elements = || root.children().filter(Node::is_element);
        let tag = |node: &Node<'_, '_>| node.tag_name().name().to_owned();
        // What the material names comes before what merely is there.
        let material = elements().find(|node| tag(node) == "surfacematerial");
        let named = |input: &str| graph.input(material?, input).and_then(|i| graph.target(i, root));
        let is_surface = |node: &Node<'_, '_>| node.attribute("type") == Some("surfaceshader");
        let surface = named("surfaceshader").or_else(|| elements().find(is_surface));
        if let Some(surface) = surface {
            for (input, role) in INPUTS {
                let Some(input) = graph.input(surface, input) else { continue };
                if let Some(Source { image, .. }) = graph.follow(input, surface)?
                    && found.images.iter().all(|(r, _)| *r != role)
                {
                    found.images.push((role, graph.file(image)?));
                }
            }
        }
        let displacement = named("displacementshader")
            .or_else(|| root.descendants().find(|node| tag(node) == "displacement"));
        let Some(displacement) = displacement else { return Ok(found) };
        let Some(input) = graph.input(displacement, "displacement") else { return Ok(found) };
        let Some(source) = graph.follow(input, displacement)? else { return Ok(found) };
        let scale = graph.number_or(displacement, "scale", 1.0)? * source.gain;
        found.images.push((MapRole::Displacement, graph.file(source.image)?));
        let zero = 0.0 - source.base / source.gain;
        let sound = scale != 0.0 && scale.is_finite() && zero.is_finite();
        found.displacement = sound.then_some(WrittenDisplacement { scale, zero });
        Ok(found)
    }
}

/// Where line `row`, from 1, begins.
fn line_start(text: &str, row: u32) -> usize {
    text.split_inclusive('\n').take(row.saturating_sub(1) as usize).map(str::len).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"<?xml version="1.0"?>
<materialx version="1.38" fileprefix="tex/">
  <nodegraph name="NG">
    <image name="diff" type="color3">
      <input name="file" type="filename" value="a_diff.jpg" colorspace="srgb_texture" />
    </image>
    <tiledimage name="nor" type="vector3"><input name="file" type="filename" value="a_nor.png" /></tiledimage>
    <normalmap name="nm" type="vector3"><input name="in" type="vector3" nodename="nor" /></normalmap>
    <output name="colour" type="color3" nodename="diff" />
    <output name="normal" type="vector3" nodename="nm" />
  </nodegraph>
  <image name="disp" type="float"><input name="file" type="filename" value="a_disp.png" /></image>
  <subtract name="mid" type="float">
    <input name="in1" type="float" nodename="disp" /><input name="in2" type="float" value="0.5" />
  </subtract>
  <multiply name="twice" type="float">
    <input name="in1" type="float" value="2" /><input name="in2" type="float" nodename="mid" />
  </multiply>
  <displacement name="D" type="displacementshader">
    <input name="displacement" type="float" nodename="twice" />
    <input name="scale" type="float" value="0.03" />
  </displacement>
  <standard_surface name="S" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="NG" output="colour" />
    <input name="normal" type="vector3" nodegraph="NG" output="normal" />
    <input name="specular_roughness" type="float" value="0.4" />
  </standard_surface>
  <surfacematerial name="M" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S" />
    <input name="displacementshader" type="displacementshader" nodename="D" />
  </surfacematerial>
</materialx>"#;

    fn read(text: &str) -> Result<MaterialX> {
        MaterialX::read_bytes(text.as_bytes(), Path::new("dir/a.mtlx"), &Limits::default())
    }

    #[test]
    fn images_and_displacement_are_found_through_graphs() {
        let found = read(TEXT).unwrap();
        let want = [
            (MapRole::Albedo, "dir/tex/a_diff.jpg"),
            (MapRole::Normal, "dir/tex/a_nor.png"),
            (MapRole::Displacement, "dir/tex/a_disp.png"),
        ];
        assert_eq!(found.images, want.map(|(role, path)| (role, PathBuf::from(path))));
        let d = found.displacement.unwrap();
        assert!((d.scale - 0.06).abs() < 1e-12 && (d.zero - 0.5).abs() < 1e-12);
    }

    #[test]
    fn arithmetic_is_put_together() {
        let graph = |nodes: &str| {
            let start = TEXT.find("  <subtract").unwrap();
            let end = TEXT.find("  <displacement name").unwrap();
            let text = format!("{}{nodes}{}", &TEXT[..start], &TEXT[end..]);
            read(&text).unwrap().displacement.map(|d| (d.scale, d.zero))
        };
        let remap = r#"<remap name="twice" type="float"><input name="in" nodename="disp" />
            <input name="outlow" value="-1" /><input name="outhigh" value="3" /></remap>"#;
        assert_eq!(graph(remap), Some((0.12, 0.25)));
        let invert =
            r#"<invert name="twice" type="float"><input name="in" nodename="disp" /></invert>"#;
        assert_eq!(graph(invert), Some((-0.03, 1.0)));
        let divide = r#"<divide name="twice" type="float"><input name="in1" nodename="disp" />
            <input name="in2" value="2" /></divide>"#;
        assert_eq!(graph(divide), Some((0.015, 0.0)));
        let from = r#"<subtract name="twice" type="float"><input name="in1" value="1" />
            <input name="in2" nodename="disp" /></subtract>"#;
        assert_eq!(graph(from), Some((-0.03, 1.0)));
        let circle =
            r#"<invert name="twice" type="float"><input name="in" nodename="twice" /></invert>"#;
        assert_eq!(graph(circle), None);
        let two = r#"<add name="twice" type="float"><input name="in1" nodename="disp" />
            <input name="in2" nodename="disp" /></add>"#;
        assert_eq!(graph(two), None);
        assert_eq!(graph(""), None);
        // Ways that fork at each of sixty nodes.
        let fork = |k: usize| {
            let next = if k == 60 { "disp".to_owned() } else { format!("n{}", k + 1) };
            format!(
                r#"<add name="n{k}"><input name="in1" nodename="{next}" /><input name="in2" nodename="{next}" /></add>"#
            )
        };
        let forks: String = (0..=60).map(fork).collect();
        assert_eq!(graph(&forks.replace("\"n0\"", "\"twice\"")), None);
    }

    #[test]
    fn what_is_not_materialx_is_refused() {
        for (text, want) in [
            ("<a", "a.mtlx:1:"),
            ("<materialx>\n<x></materialx>", "a.mtlx:2:"),
            ("<scene />", "root element: scene; allowed: materialx"),
            ("<!DOCTYPE a [<!ENTITY b \"c\">]><materialx>&b;</materialx>", "syntax"),
            (&TEXT.replace("0.03", "deep"), "scale: \"deep\"; allowed: a number"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(want), "{text}: {error}");
        }
        for end in (0..TEXT.len()).step_by(7) {
            let _ = read(&TEXT[..end]);
        }
        let many = format!("<materialx>{}</materialx>", "<a/>".repeat(70_000));
        assert!(read(&many).is_err());
        assert!(read(&"<a>".repeat(100_000)).is_err());
        let small = Limits { max_bytes: 100 };
        let refused = MaterialX::read_bytes(TEXT.as_bytes(), Path::new("a"), &small);
        assert!(matches!(refused, Err(Error::Limit { .. })));
    }
}

//! Ways through the nodes of a MaterialX document.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use roxmltree::Node;

use crate::error::{Error, Excerpt, Place, Result};

/// Most nodes on the way to an image: a longer way runs in a circle.
const MAX_DEPTH: u32 = 64;

/// Most nodes that are looked at: ways fork, and may meet again.
const MAX_STEPS: u32 = 1 << 14;

/// A document for looking up names.
pub(super) struct Graph<'a, 'input> {
    steps: Cell<u32>,
    path: &'a Path,
    text: &'a str,
    root: Node<'a, 'input>,
}

/// An image at the end of a way, and what arithmetic made of its value: `gain * value + base`.
#[derive(Clone, Copy)]
pub(super) struct Source<'a, 'input> {
    pub image: Node<'a, 'input>,
    pub gain: f64,
    pub base: f64,
}

/// What stands at an input: a number, or something that leads to an image.
enum Operand<'a, 'input> {
    Number(f64),
    Image(Source<'a, 'input>),
}

impl<'a, 'input> Graph<'a, 'input> {
    pub fn new(path: &'a Path, text: &'a str, root: Node<'a, 'input>) -> Self {
        Self { steps: Cell::new(0), path, text, root }
    }

    pub fn root(&self) -> Node<'a, 'input> {
        self.root
    }

    /// The input `name` of a node.
    pub fn input(&self, node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
        node.children().find(|child| {
            child.tag_name().name() == "input" && child.attribute("name") == Some(name)
        })
    }

    /// The element `name` of `scope`.
    fn named(&self, scope: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
        scope.children().find(|child| child.is_element() && child.attribute("name") == Some(name))
    }

    /// The node that an input, of a node inside `scope`, is connected with.
    pub fn target(
        &self,
        input: Node<'a, 'input>,
        scope: Node<'a, 'input>,
    ) -> Option<Node<'a, 'input>> {
        if let Some(graph) = input.attribute("nodegraph") {
            let graph = self.named(self.root, graph)?;
            let is_output = |child: &Node<'_, '_>| child.tag_name().name() == "output";
            let output = match input.attribute("output") {
                Some(name) => self.named(graph, name)?,
                None => graph.children().find(is_output)?,
            };
            return self.named(graph, output.attribute("nodename")?);
        }
        let name = input.attribute("nodename")?;
        self.named(scope, name).or_else(|| self.named(self.root, name))
    }

    /// The image that an input of `node` leads to, if it does.
    pub fn follow(
        &self,
        input: Node<'a, 'input>,
        node: Node<'a, 'input>,
    ) -> Result<Option<Source<'a, 'input>>> {
        match self.operand(input, node, 0)? {
            Some(Operand::Image(source)) if source.gain != 0.0 => Ok(Some(source)),
            _ => Ok(None),
        }
    }

    fn operand(
        &self,
        input: Node<'a, 'input>,
        node: Node<'a, 'input>,
        depth: u32,
    ) -> Result<Option<Operand<'a, 'input>>> {
        self.steps.set(self.steps.get() + 1);
        if depth == MAX_DEPTH || self.steps.get() > MAX_STEPS {
            return Ok(None);
        }
        let scope = node.parent_element().unwrap_or(self.root);
        if let Some(target) = self.target(input, scope) {
            return self.value(target, depth + 1);
        }
        match input.attribute("value").map(str::trim) {
            // Of a colour, the first channel.
            Some(value) => {
                let first = value.split(',').next().unwrap_or_default().trim();
                Ok(first.parse().ok().filter(|n: &f64| n.is_finite()).map(Operand::Number))
            }
            None => Ok(None),
        }
    }

    /// What a node gives out.
    fn value(&self, node: Node<'a, 'input>, depth: u32) -> Result<Option<Operand<'a, 'input>>> {
        use Operand::{Image, Number};
        let operand = |name: &str| match self.input(node, name) {
            Some(input) => self.operand(input, node, depth),
            None => Ok(None),
        };
        let shift = |source: Source<'a, 'input>, gain: f64, base: f64| {
            Image(Source { gain: source.gain * gain, base: source.base * gain + base, ..source })
        };
        let tag = node.tag_name().name();
        Ok(match tag {
            "image" | "tiledimage" | "UsdUVTexture" | "gltf_image" | "gltf_normalmap_image" => {
                Some(Image(Source { image: node, gain: 1.0, base: 0.0 }))
            }
            "constant" => operand("value")?,
            "add" | "subtract" | "multiply" | "divide" => {
                match (tag, operand("in1")?, operand("in2")?) {
                    ("add", Some(Image(s)), Some(Number(n)))
                    | ("add", Some(Number(n)), Some(Image(s))) => Some(shift(s, 1.0, n)),
                    ("subtract", Some(Image(s)), Some(Number(n))) => Some(shift(s, 1.0, -n)),
                    ("subtract", Some(Number(n)), Some(Image(s))) => Some(shift(s, -1.0, n)),
                    ("multiply", Some(Image(s)), Some(Number(n)))
                    | ("multiply", Some(Number(n)), Some(Image(s))) => Some(shift(s, n, 0.0)),
                    ("divide", Some(Image(s)), Some(Number(n))) if n != 0.0 => {
                        Some(shift(s, 1.0 / n, 0.0))
                    }
                    _ => None,
                }
            }
            "invert" => match operand("in")? {
                Some(Image(s)) => Some(shift(s, -1.0, self.number_or(node, "amount", 1.0)?)),
                other => other,
            },
            "remap" | "range" => {
                let number = |name, default| self.number_or(node, name, default);
                let (low, high) = (number("inlow", 0.0)?, number("inhigh", 1.0)?);
                let (from, to) = (number("outlow", 0.0)?, number("outhigh", 1.0)?);
                match operand("in")? {
                    Some(Image(s)) if high != low => {
                        let gain = (to - from) / (high - low);
                        Some(shift(s, gain, from - low * gain))
                    }
                    other => other,
                }
            }
            // A node with one input hands its image on: extract, convert, normalmap, clamp.
            _ => operand("in")?,
        })
    }

    /// The number of the input `name` of a node, or `default`.
    pub fn number_or(&self, node: Node<'a, 'input>, name: &str, default: f64) -> Result<f64> {
        let value = self.input(node, name).and_then(|input| input.attribute("value"));
        let Some(value) = value else { return Ok(default) };
        let number = value.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        number.ok_or_else(|| self.fault(node, name, value, "a number"))
    }

    /// The file of an image.
    pub fn file(&self, image: Node<'a, 'input>) -> Result<PathBuf> {
        let value = self.input(image, "file").and_then(|input| input.attribute("value"));
        let Some(value) = value.map(str::trim).filter(|value| !value.is_empty()) else {
            return Err(self.fault(image, "file", "", "the name of a file"));
        };
        // The prefix of every element around it, the outermost first.
        let mut prefixes: Vec<_> =
            image.ancestors().filter_map(|node| node.attribute("fileprefix")).collect();
        prefixes.reverse();
        let name = format!("{}{value}", prefixes.concat()).replace('\\', "/");
        Ok(self.path.parent().unwrap_or(Path::new("")).join(name))
    }

    fn fault(&self, node: Node<'_, '_>, what: &str, found: &str, allowed: &str) -> Error {
        let line = node.range().start..node.range().start + 1;
        let place = Place::Text(Excerpt::new(self.text, line));
        Error::invalid(self.path, place, what, format!("{found:?}"), allowed)
    }
}

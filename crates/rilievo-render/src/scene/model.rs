//! [`Model`]: how light is scattered, with every input a constant or a texture.
//!
//! What the formulas are is told where they are evaluated, in [`crate::bsdf`]. A roughness `r` means
//! a GGX width of `r^2`.

use std::sync::Arc;

use super::material::{Material, MaterialError};
use crate::bsdf::GlassTable;
use crate::colour::{Rgb, is_radiance};
use crate::texture::{ColourInput, NumberInput, Texture};

/// How light is scattered.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Model {
    /// The paper's: Lambert and a share around the mirror direction, by the fields of [`Material`].
    #[default]
    Paper,
    /// A diffuser.
    Diffuse(Diffuse),
    /// A metal.
    Conductor(Conductor),
    /// A clear body: it reflects and refracts.
    Glass(Glass),
    /// A clear sheet without thickness: a window, a bubble.
    ThinGlass(ThinGlass),
    /// Most of what is made and found, by a few inputs.
    Principled(Box<Principled>),
    /// Two materials side by side.
    Mix(Arc<Mix>),
}

/// Oren and Nayar's diffuser, in the form that keeps its energy.
#[derive(Clone, Debug, PartialEq)]
pub struct Diffuse {
    /// Share of white light that comes back.
    pub colour: ColourInput,
    /// 0 is Lambert's; up to 1.
    pub roughness: NumberInput,
}

/// What a metal reflects along its normal and at the edge.
#[derive(Clone, Debug, PartialEq)]
pub enum Metal {
    /// Colour seen straight on, and at 82 degrees as a factor on what Schlick's formula gives there.
    Colours {
        /// Reflectance along the normal.
        facing: ColourInput,
        /// The factor at 82 degrees.
        edge: ColourInput,
    },
    /// Index of refraction `eta - i k` for red, green and blue.
    Index {
        /// The real part.
        eta: Rgb,
        /// What is absorbed.
        k: Rgb,
    },
}

/// A rough or smooth metal.
#[derive(Clone, Debug, PartialEq)]
pub struct Conductor {
    /// Its colour.
    pub metal: Metal,
    /// 0 is a mirror; up to 1.
    pub roughness: NumberInput,
    /// Whether light that meets several facets is put back.
    pub compensated: bool,
}

/// A rough or smooth clear body.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    /// Index of refraction of the side behind the front over that before it, and the energy that
    /// single facets lose with it.
    pub table: Arc<GlassTable>,
    /// Factor on what goes through.
    pub colour: ColourInput,
    /// 0 is clear; up to 1.
    pub roughness: NumberInput,
    /// Whether light that meets several facets is put back.
    pub compensated: bool,
}

/// A rough or smooth clear sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct ThinGlass {
    /// Index of refraction of the sheet.
    pub ior: f64,
    /// Factor on what goes straight through.
    pub colour: ColourInput,
    /// 0 is clear; up to 1.
    pub roughness: NumberInput,
}

/// glTF's metal and roughness with the layers of OpenPBR that matter most: from the top a sheen, a
/// clear coat, then metal, a diffuser under gloss, or glass.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled {
    /// Colour of the diffuser, of the metal, and of what goes through the glass.
    pub base_colour: ColourInput,
    /// Share of metal.
    pub metallic: NumberInput,
    /// Of the gloss, the metal and the glass.
    pub roughness: NumberInput,
    /// Of the diffuser: 0 is Lambert's.
    pub diffuse_roughness: NumberInput,
    /// Factor on the gloss.
    pub specular: NumberInput,
    /// Tint of the gloss seen straight on.
    pub specular_colour: ColourInput,
    /// Index of refraction of the gloss and the glass.
    pub glass: Arc<GlassTable>,
    /// Share of the diffuser that is glass instead.
    pub transmission: NumberInput,
    /// Whether the glass is a sheet without thickness.
    pub thin: bool,
    /// Share of the surface that is there at all; light passes straight through the rest.
    pub opacity: NumberInput,
    /// Weight of a clear coat of index 1.5.
    pub coat: NumberInput,
    /// Roughness of the coat.
    pub coat_roughness: NumberInput,
    /// Colour of fibres that show at grazing angles.
    pub sheen: ColourInput,
    /// Roughness of the sheen.
    pub sheen_roughness: NumberInput,
}

/// Two materials, each on a share of the surface too fine to be seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Mix {
    /// The materials. What they emit is not used: a mix emits by its own fields.
    pub materials: [Material; 2],
    /// Share of the second.
    pub share: NumberInput,
}

impl Principled {
    /// A grey plastic: base colour 0.5, no metal, roughness 0.5, index 1.5.
    pub fn new() -> Self {
        let number = NumberInput::uniform;
        Self {
            base_colour: ColourInput::uniform(Rgb::splat(0.5)),
            metallic: number(0.0),
            roughness: number(0.5),
            diffuse_roughness: number(0.0),
            specular: number(1.0),
            specular_colour: ColourInput::uniform(Rgb::ONE),
            glass: GlassTable::common(),
            transmission: number(0.0),
            thin: false,
            opacity: number(1.0),
            coat: number(0.0),
            coat_roughness: number(0.0),
            sheen: ColourInput::uniform(Rgb::ZERO),
            sheen_roughness: number(0.5),
        }
    }
}

impl Default for Principled {
    fn default() -> Self {
        Self::new()
    }
}

/// Inputs by the names of their fields.
type Named<'a, T> = Vec<(&'static str, &'a T)>;

impl Model {
    /// Its inputs of colours and of numbers, by the names of their fields. A mix has those of its
    /// share alone.
    fn inputs(&self) -> (Named<'_, ColourInput>, Named<'_, NumberInput>) {
        match self {
            Self::Paper => (Vec::new(), Vec::new()),
            Self::Diffuse(d) => (vec![("colour", &d.colour)], vec![("roughness", &d.roughness)]),
            Self::Conductor(c) => {
                let colours = match &c.metal {
                    Metal::Colours { facing, edge } => vec![("colour", facing), ("edge", edge)],
                    Metal::Index { .. } => Vec::new(),
                };
                (colours, vec![("roughness", &c.roughness)])
            }
            Self::Glass(g) => (vec![("colour", &g.colour)], vec![("roughness", &g.roughness)]),
            Self::ThinGlass(g) => (vec![("colour", &g.colour)], vec![("roughness", &g.roughness)]),
            Self::Principled(p) => (
                vec![
                    ("base_colour", &p.base_colour),
                    ("specular_colour", &p.specular_colour),
                    ("sheen", &p.sheen),
                ],
                vec![
                    ("metallic", &p.metallic),
                    ("roughness", &p.roughness),
                    ("diffuse_roughness", &p.diffuse_roughness),
                    ("specular", &p.specular),
                    ("transmission", &p.transmission),
                    ("opacity", &p.opacity),
                    ("coat", &p.coat),
                    ("coat_roughness", &p.coat_roughness),
                    ("sheen_roughness", &p.sheen_roughness),
                ],
            ),
            Self::Mix(mix) => (Vec::new(), vec![("share", &mix.share)]),
        }
    }

    /// The textures of its inputs; those of the parts of a mix, too.
    pub(crate) fn textures(&self) -> Vec<&Texture> {
        let (colours, numbers) = self.inputs();
        let colours = colours.into_iter().filter_map(|(_, input)| input.texture.as_ref());
        let numbers = numbers.into_iter().filter_map(|(_, input)| Some(&input.texture.as_ref()?.0));
        let mut all: Vec<_> = colours.chain(numbers).collect();
        if let Self::Mix(mix) = self {
            all.extend(mix.materials.iter().flat_map(Material::textures));
        }
        all
    }

    /// Shows every texture to `visit`.
    pub(super) fn each_texture(&mut self, visit: &mut dyn FnMut(&mut Texture)) {
        let (colours, numbers): (Vec<&mut ColourInput>, Vec<&mut NumberInput>) = match self {
            Self::Paper => return,
            Self::Diffuse(d) => (vec![&mut d.colour], vec![&mut d.roughness]),
            Self::Conductor(c) => {
                let colours = match &mut c.metal {
                    Metal::Colours { facing, edge } => vec![facing, edge],
                    Metal::Index { .. } => Vec::new(),
                };
                (colours, vec![&mut c.roughness])
            }
            Self::Glass(g) => (vec![&mut g.colour], vec![&mut g.roughness]),
            Self::ThinGlass(g) => (vec![&mut g.colour], vec![&mut g.roughness]),
            Self::Principled(p) => (
                vec![&mut p.base_colour, &mut p.specular_colour, &mut p.sheen],
                vec![
                    &mut p.metallic,
                    &mut p.roughness,
                    &mut p.diffuse_roughness,
                    &mut p.specular,
                    &mut p.transmission,
                    &mut p.opacity,
                    &mut p.coat,
                    &mut p.coat_roughness,
                    &mut p.sheen_roughness,
                ],
            ),
            Self::Mix(mix) => {
                let mix = Arc::make_mut(mix);
                mix.materials.iter_mut().for_each(|material| material.each_texture(visit));
                (Vec::new(), vec![&mut mix.share])
            }
        };
        let colours = colours.into_iter().filter_map(|input| input.texture.as_mut());
        let numbers = numbers.into_iter().filter_map(|input| Some(&mut input.texture.as_mut()?.0));
        colours.chain(numbers).for_each(visit);
    }

    /// Checks every input.
    ///
    /// # Errors
    /// [`MaterialError`] names the first that is out of range.
    pub(super) fn check(&self) -> Result<(), MaterialError> {
        let (colours, numbers) = self.inputs();
        for (part, input) in colours {
            if !is_radiance(input.value) || input.value.max_element() > 1.0 {
                return Err(MaterialError::Share { part, found: input.value });
            }
        }
        for (part, input) in numbers {
            if !(0.0..=1.0).contains(&input.value) {
                return Err(MaterialError::Share { part, found: Rgb::splat(input.value) });
            }
        }
        match self {
            Self::Conductor(Conductor { metal: Metal::Index { eta, k }, .. }) => {
                for (part, found) in [("eta", *eta), ("k", *k)] {
                    if !is_radiance(found) {
                        return Err(MaterialError::Colour { part, found });
                    }
                }
            }
            Self::ThinGlass(ThinGlass { ior, .. }) if !GlassTable::IORS.contains(ior) => {
                return Err(MaterialError::Ior { found: *ior });
            }
            Self::Mix(mix) => {
                for material in &mix.materials {
                    material.check()?;
                }
            }
            _ => {}
        }
        Ok(())
    }
}

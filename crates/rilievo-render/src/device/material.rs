//! Materials in words: what they are, then their inputs, all of one kind, so that a shader reads them in one loop.

use std::collections::HashMap;

use rilievo::map::NormalConvention;

use super::texture::Images;
use super::{NOTHING, Parts, Uncovered, Words};
use crate::bsdf::{GlassTable, gloss_table, sheen_table};
use crate::colour::Rgb;
use crate::scene::{Conductor, Glass, Material, Metal, Model, Principled, Reflectance, ThinGlass};
use crate::texture::{Channel, ColourInput, NumberInput, Texture};

/// Words of a material before its inputs.
const HEAD_WORDS: u32 = 12;

/// The materials that were written, each once, by address.
#[derive(Default)]
pub(super) struct Materials {
    places: HashMap<usize, u32>,
    images: Images,
    /// Places of tables of glass, by the bits of their index.
    glass: HashMap<u64, u32>,
    tables: bool,
}

/// An input, with its texture written.
enum Input {
    Colour(Rgb, u32),
    Number([u32; 3], f64),
}

impl Materials {
    /// Writes a material; returns its place.
    ///
    /// # Errors
    /// [`Uncovered`] for what no shader knows.
    pub(super) fn place(
        &mut self,
        words: &mut Words,
        parts: &mut Parts,
        material: &Material,
    ) -> Result<u32, Uncovered> {
        let address = std::ptr::from_ref(material).addr();
        if let Some(place) = self.places.get(&address) {
            return Ok(*place);
        }
        let mut own = Own { materials: self, words, parts };
        let place = own.write(material)?;
        self.places.insert(address, place);
        Ok(place)
    }
}

/// What a material is written with.
struct Own<'a> {
    materials: &'a mut Materials,
    words: &'a mut Words,
    parts: &'a mut Parts,
}

impl Own<'_> {
    fn write(&mut self, material: &Material) -> Result<u32, Uncovered> {
        let (diffuse, texture) = match &material.diffuse {
            Reflectance::Uniform(colour) => (*colour, NOTHING),
            Reflectance::Textured(texture) => (Rgb::ONE, self.texture(texture)?),
        };
        let emission = match &material.emission {
            Some(texture) => self.texture(texture)?,
            None => NOTHING,
        };
        let path = self.parts.path;
        let (kind, words, inputs) = if path { self.model(&material.model)? } else { NO_MODEL };
        let normals = match &material.normals {
            Some(normals) if path => {
                self.parts.normals = true;
                let sign = match normals.convention {
                    NormalConvention::OpenGl => 1.0,
                    NormalConvention::DirectX => -1.0,
                };
                (self.texture(&normals.texture)?, normals.strength, sign * normals.strength)
            }
            _ => (NOTHING, 0.0, 0.0),
        };
        let detail = Input::Colour(Rgb::ONE, normals.0);
        let first =
            [Input::Colour(diffuse, texture), Input::Colour(material.emitted, emission), detail];
        let place = self.words.place();
        self.words.push(kind);
        words.into_iter().for_each(|word| self.words.push(word));
        self.words.triple(material.reflective);
        self.words.float(material.roughness * material.roughness);
        self.words.float(normals.1);
        self.words.float(normals.2);
        let inputs: Vec<Input> = first.into_iter().chain(inputs).collect();
        let colours = inputs.iter().map(|input| u32::from(matches!(input, Input::Colour(..))));
        self.words.push((0..).zip(colours).map(|(k, colour)| colour << k).sum());
        self.words.push(inputs.len() as u32);
        debug_assert_eq!(self.words.place() - place, HEAD_WORDS);
        for input in inputs {
            match input {
                Input::Colour(value, texture) => {
                    self.words.triple(value);
                    self.words.push(texture);
                }
                Input::Number(of_texture, value) => {
                    self.words.float(value);
                    of_texture.into_iter().for_each(|word| self.words.push(word));
                }
            }
        }
        Ok(place)
    }

    /// A model: its kind, three words of its own, its inputs of four words each.
    fn model(&mut self, model: &Model) -> Result<(u32, [u32; 3], Vec<Input>), Uncovered> {
        Ok(match model {
            Model::Paper => NO_MODEL,
            Model::Diffuse(model) => {
                let inputs = vec![self.colour(&model.colour)?, self.number(&model.roughness)?];
                (1, [0; 3], inputs)
            }
            Model::Conductor(Conductor { metal, roughness, compensated }) => {
                self.parts.metals = true;
                self.tables();
                let roughness = self.number(roughness)?;
                let (index, first, second) = match metal {
                    Metal::Colours { facing, edge } => {
                        (0, self.colour(facing)?, self.colour(edge)?)
                    }
                    Metal::Index { eta, k } => {
                        (1, Input::Colour(*eta, NOTHING), Input::Colour(*k, NOTHING))
                    }
                };
                (2, [index, u32::from(*compensated), 0], vec![roughness, first, second])
            }
            Model::Glass(Glass { table, colour, roughness, compensated }) => {
                self.parts.glass = true;
                let place = self.glass(table);
                let words = [bits(table.ior()), u32::from(*compensated), place];
                (3, words, vec![self.colour(colour)?, self.number(roughness)?])
            }
            Model::ThinGlass(ThinGlass { ior, colour, roughness }) => {
                self.parts.glass = true;
                self.tables();
                let words = [bits(*ior), 1, NOTHING];
                (4, words, vec![self.colour(colour)?, self.number(roughness)?])
            }
            Model::Principled(model) => self.principled(model)?,
            Model::Mix(mix) => {
                self.parts.mixes = true;
                let inner = mix.materials.iter().any(|part| matches!(part.model, Model::Mix(_)));
                if inner {
                    return Err(Uncovered("a mix of mixes"));
                }
                let [first, second] = &mix.materials;
                let places = [self.write(first)?, self.write(second)?];
                (6, [places[0], places[1], 0], vec![self.number(&mix.share)?])
            }
        })
    }

    fn principled(&mut self, p: &Principled) -> Result<(u32, [u32; 3], Vec<Input>), Uncovered> {
        self.parts.principled = true;
        self.tables();
        let clear = p.transmission.value > 0.0;
        self.parts.glass |= clear;
        let table = if clear && !p.thin { self.glass(&p.glass) } else { NOTHING };
        let inputs = vec![
            self.colour(&p.base_colour)?,
            self.number(&p.metallic)?,
            self.number(&p.roughness)?,
            self.number(&p.diffuse_roughness)?,
            self.number(&p.specular)?,
            self.colour(&p.specular_colour)?,
            self.number(&p.transmission)?,
            self.number(&p.opacity)?,
            self.number(&p.coat)?,
            self.number(&p.coat_roughness)?,
            self.colour(&p.sheen)?,
            self.number(&p.sheen_roughness)?,
        ];
        Ok((5, [bits(p.glass.ior()), u32::from(p.thin), table], inputs))
    }

    fn texture(&mut self, texture: &Texture) -> Result<u32, Uncovered> {
        self.parts.images = true;
        self.materials.images.texture(self.words, texture, self.parts.path)
    }

    fn colour(&mut self, input: &ColourInput) -> Result<Input, Uncovered> {
        let texture = match &input.texture {
            Some(texture) => self.texture(texture)?,
            None => NOTHING,
        };
        Ok(Input::Colour(input.value, texture))
    }

    fn number(&mut self, input: &NumberInput) -> Result<Input, Uncovered> {
        let of_texture = match &input.texture {
            None => [NOTHING, 0, 0],
            Some((texture, channel)) => {
                let channel = match channel {
                    Channel::Red => 0,
                    Channel::Green => 1,
                    Channel::Blue => 2,
                };
                [self.texture(texture)?, channel, u32::from(input.invert)]
            }
        };
        Ok(Input::Number(of_texture, input.value))
    }

    /// Tables of gloss and sheen, once.
    fn tables(&mut self) {
        if !std::mem::replace(&mut self.materials.tables, true) {
            for (name, table) in [("GLOSS_TABLE", gloss_table()), ("SHEEN_TABLE", sheen_table())] {
                let place = self.grid(&table);
                self.words.set(name, place);
            }
        }
    }

    /// The tables of a glass seen from behind and from the front, one after the other.
    fn glass(&mut self, table: &GlassTable) -> u32 {
        self.tables();
        let key = table.ior().to_bits();
        if let Some(place) = self.materials.glass.get(&key) {
            return *place;
        }
        let [behind, front] = table.sides();
        let place = self.grid(&behind);
        self.grid(&front);
        self.materials.glass.insert(key, place);
        place
    }

    fn grid(&mut self, numbers: &[[f64; 2]]) -> u32 {
        let place = self.words.place();
        numbers.as_flattened().iter().for_each(|&x| self.words.float(x));
        place
    }
}

/// The paper's model, which has no numbers of its own.
const NO_MODEL: (u32, [u32; 3], Vec<Input>) = (0, [0; 3], Vec::new());

fn bits(x: f64) -> u32 {
    super::single(x).to_bits()
}

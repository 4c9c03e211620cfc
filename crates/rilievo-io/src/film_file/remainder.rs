//! [`Remainder`]: what a picture of a film that is not done holds beside the picture.

use std::sync::Arc;

use rilievo_render::Aov;
use rilievo_render::film::{Film, Tile};

use super::OWN;
use super::digits::{COUNTS, DIGITS, digit, sum_names};
use crate::image::{Attribute, Picture, PictureChannel, Stored, Values};

/// What a picture of an unfinished film holds beside the picture. Its channels are made while they
/// are written, so it takes no memory to speak of.
#[derive(Clone, Debug)]
pub struct Remainder<'a> {
    film: &'a Film,
    attributes: Vec<(String, Attribute)>,
}

impl<'a> Remainder<'a> {
    /// The attribute of the flags that a render was begun with.
    pub const FLAGS: &'static str = "rilievo/flags";

    /// Of a film of an image of `image` pixels, of a render begun with some flags.
    pub fn of(film: &'a Film, image: [u32; 2], fingerprint: &str, flags: &str) -> Self {
        let list =
            |numbers: &[u32]| numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        let Tile { corner, size } = film.window();
        let layers: Vec<_> = film.layers().iter().map(|layer| layer.aov().name()).collect();
        let values = [
            fingerprint.to_owned(),
            list(&image),
            list(&[corner, size].concat()),
            list(&film.samples()),
            layers.join(" "),
            flags.to_owned(),
        ];
        let names = OWN.iter().map(|name| (*name).to_owned());
        let attributes = names.zip(values.map(Attribute::Text)).collect();
        Self { film, attributes }
    }

    /// Adds its channels and attributes to a picture of the film.
    pub fn add_to(&self, picture: &mut Picture<'a>) {
        let mut push = |name: String, value: Arc<dyn Fn(usize) -> f32 + Send + Sync + 'a>| {
            let (values, stored) = (Values::Made(value), Stored::Float);
            picture.channels.push(PictureChannel { name, values, stored });
        };
        let finished = self.film.finished();
        push("rilievo.finished".into(), Arc::new(|at| f32::from(u8::from(finished[at]))));
        if let Some(sums) = self.film.sums() {
            let (counts, values, stride) = (sums.counts(), sums.values(), sums.stride());
            for count in COUNTS {
                let name = format!("rilievo.count.{}", count.name);
                push(name, Arc::new(move |at| (count.get)(&counts[at]) as f32));
            }
            for (place, name) in sum_names(self.film).into_iter().enumerate() {
                for k in 0..DIGITS {
                    let name = format!("rilievo.sum.{name}.{k}");
                    push(name, Arc::new(move |at| digit(values[at * stride + place], k)));
                }
            }
        }
        picture.attributes.extend(self.attributes.iter().cloned());
    }

    /// Channels that it adds to a picture of a film of such layers.
    pub fn channels(aovs: &[Aov], sums: bool) -> usize {
        let channels: usize = aovs.iter().map(|aov| aov.channels().len()).sum();
        1 + if sums { COUNTS.len() + DIGITS * (4 + channels) } else { 0 }
    }
}

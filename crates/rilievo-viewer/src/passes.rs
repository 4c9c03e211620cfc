//! [`Pass`]: the order in which a picture gets better.
//!
//! First the whole picture at an eighth of its width, then a quarter, a half and all of it, one ray a pixel and
//! light; then, tile by tile in place of that, what the scene asks for. Each pass is a render of its own,
//! so the last one is the picture of `rilievo render`, bit for bit.

use rilievo_render::{Aov, Film, Integrator, RenderSettings};

use crate::session::Look;

/// Pixels along the shorter side below which a picture is too coarse to tell anything.
const COARSEST: u32 = 24;

/// One render of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// How many pixels of the picture one of this pass is wide.
    pub factor: u32,
    /// Pixels.
    pub size: [u32; 2],
    /// How to render.
    pub settings: RenderSettings,
    /// Whether rays go through the middles of pixels.
    pub centers: bool,
    /// Layers to keep.
    pub layers: Vec<Aov>,
    /// Whether nothing better comes after it.
    pub last: bool,
}

/// The passes of a picture of `size` pixels.
pub fn passes(size: [u32; 2], settings: &RenderSettings, look: Look) -> Vec<Pass> {
    let (integrator, layers) = match look {
        Look::Colour => (settings.integrator, Vec::new()),
        Look::Layer(aov) => (Integrator::Aov, vec![aov]),
    };
    let full = RenderSettings { integrator, ..*settings };
    let quick = RenderSettings {
        samples: 1,
        shadow_samples: 1,
        glossy_samples: 1,
        diffuse_samples: full.diffuse_samples.min(1),
        max_depth: full.max_depth.min(2),
        ..full
    };
    let coarse = |factor: u32| Pass {
        factor,
        size: size.map(|n| n.div_ceil(factor)),
        settings: quick,
        centers: true,
        layers: layers.clone(),
        last: false,
    };
    let told = |pass: &Pass| pass.size.iter().all(|&n| n >= COARSEST) || pass.factor == 1;
    let mut all: Vec<_> = [8, 4, 2, 1].into_iter().map(coarse).filter(told).collect();
    // What takes all samples of a pixel at once would keep one waiting.
    if !integrator.sums() && full.samples >= 16 {
        let some = RenderSettings { samples: 4, ..full };
        all.push(Pass { settings: some, centers: false, ..coarse(1) });
    }
    all.push(Pass { settings: full, centers: false, last: true, ..coarse(1) });
    all
}

/// What a film shows, by pixel.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Linear radiance.
    Radiance(Vec<[f32; 3]>),
    /// sRGB codes of a layer in false colours.
    Codes(Vec<[u8; 3]>),
}

/// A picture on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels.
    pub size: [u32; 2],
    /// What they show.
    pub content: Content,
    /// The factor of its pass.
    pub factor: u32,
    /// Whether it is the picture of `rilievo render`.
    pub complete: bool,
}

impl Frame {
    /// What a pass left.
    pub fn of(film: &Film, look: Look, pass: &Pass) -> Self {
        let content = match look {
            Look::Colour => Content::Radiance(film.radiance().to_vec()),
            Look::Layer(aov) => Content::Codes(
                film.layer(aov)
                    .map(rilievo_render::film::false_colour::false_colour)
                    .unwrap_or_default(),
            ),
        };
        let complete = pass.last && film.is_complete();
        Self { size: film.resolution(), content, factor: pass.factor, complete }
    }

    /// The same with the pixels of a film that are done in place of its own. Layers in false colours
    /// depend on all pixels at once and wait until all are done.
    #[must_use]
    pub fn under(&self, film: &Film) -> Self {
        let Content::Radiance(old) = &self.content else { return self.clone() };
        let size = film.resolution();
        let taken: Box<dyn Fn(usize) -> bool> = match film.sums() {
            Some(sums) => Box::new(|at| sums.counts()[at].taken > 0),
            None => Box::new(|at| film.finished()[at]),
        };
        let mut pixels = Vec::with_capacity(film.radiance().len());
        for (at, new) in film.radiance().iter().enumerate() {
            if taken(at) {
                pixels.push(*new);
                continue;
            }
            let place = [at % size[0] as usize, at / size[0] as usize];
            let [x, y] = [0, 1].map(|axis| {
                let from = place[axis] * self.size[axis] as usize / size[axis] as usize;
                from.min(self.size[axis] as usize - 1)
            });
            pixels.push(old[y * self.size[0] as usize + x]);
        }
        Self { size, content: Content::Radiance(pixels), factor: 1, complete: false }
    }
}

/// The largest picture of these proportions that fits a window; never larger than `most` a side.
pub fn fitted(resolution: [u32; 2], window: [u32; 2]) -> [u32; 2] {
    let [width, height] = resolution.map(f64::from);
    let scale = (f64::from(window[0]) / width).min(f64::from(window[1]) / height);
    [width, height].map(|n| ((n * scale).round() as u32).clamp(1, 4096))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rilievo_render::film::Tile;

    #[test]
    fn pictures_get_better_and_end_in_what_the_scene_asks_for() {
        let settings = RenderSettings { samples: 64, ..RenderSettings::default() };
        for integrator in Integrator::ALL {
            let settings = RenderSettings { integrator, ..settings };
            let all = passes([640, 480], &settings, Look::Colour);
            assert_eq!(all[0].size, [80, 60]);
            assert!(all.windows(2).all(|two| two[0].factor >= two[1].factor));
            let last = all.last().unwrap();
            assert_eq!((last.settings, last.size, last.last), (settings, [640, 480], true));
            assert_eq!(all.iter().filter(|pass| pass.last).count(), 1);
        }
        let steps = passes([640, 480], &settings, Look::Layer(Aov::Steps));
        assert!(steps.iter().all(|pass| pass.settings.integrator == Integrator::Aov));
        assert_eq!(steps[0].layers, [Aov::Steps]);
        // A stamp begins where there is something to see.
        assert_eq!(passes([64, 48], &settings, Look::Colour)[0].factor, 2);
        assert_eq!(passes([4, 4], &settings, Look::Colour)[0].factor, 1);
    }

    #[test]
    fn pictures_keep_their_proportions_in_a_window() {
        assert_eq!(fitted([768, 576], [1000, 600]), [800, 600]);
        assert_eq!(fitted([768, 576], [400, 600]), [400, 300]);
        assert_eq!(fitted([1000, 1], [500, 500]), [500, 1]);
    }

    #[test]
    fn pixels_that_are_done_lie_over_the_coarser_picture() {
        let coarse = Frame {
            size: [2, 1],
            content: Content::Radiance(vec![[1.0; 3], [2.0; 3]]),
            factor: 2,
            complete: false,
        };
        let film = Film::of_window(Tile::whole([4, 2]), [0, 1], &[], false).unwrap();
        let shown = coarse.under(&film);
        let [one, two] = [[1.0; 3], [2.0; 3]];
        let expected = vec![one, one, two, two, one, one, two, two];
        assert_eq!(shown.content, Content::Radiance(expected));
    }
}

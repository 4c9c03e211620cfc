//! [`Panel`]: curves over map sizes, both axes logarithmic.

use super::svg::{Anchor, Svg};

/// A curve: a colour, and figures by size.
pub struct Curve {
    pub colour: &'static str,
    pub points: Vec<(u32, f64)>,
}

/// One set of axes.
pub struct Panel<'a> {
    pub title: &'a str,
    pub curves: Vec<Curve>,
}

/// Width and height of a panel with its labels.
pub const PANEL: [f64; 2] = [250.0, 220.0];

const LEFT: f64 = 40.0;
const TOP: f64 = 26.0;
const INSIDE: [f64; 2] = [PANEL[0] - LEFT - 14.0, PANEL[1] - TOP - 26.0];

impl Panel<'_> {
    /// Draws the panel with its upper left corner at `corner`; `low` to `high` are the figures at
    /// the ends of its upright axis.
    pub fn draw(&self, svg: &mut Svg, corner: [f64; 2], [low, high]: [f64; 2]) {
        let origin = [corner[0] + LEFT, corner[1] + TOP];
        let sizes = self.sizes();
        let [Some(&first), Some(&last)] = [sizes.first(), sizes.last()] else {
            return;
        };
        let x = |size: u32| origin[0] + INSIDE[0] * share(size.into(), first.into(), last.into());
        let y = |figure: f64| origin[1] + INSIDE[1] * (1.0 - share(figure, low, high));
        let right = origin[0] + INSIDE[0];
        svg.text("title", Anchor::Start, [origin[0], corner[1] + 16.0], self.title);
        for tick in ticks(low, high) {
            svg.line("grid", [origin[0], y(tick)], [right, y(tick)]);
            let at = [origin[0] - 5.0, y(tick) + 4.0];
            svg.text("small", Anchor::End, at, &tick.to_string());
        }
        let ground = origin[1] + INSIDE[1];
        svg.line("axis", [origin[0], ground], [right, ground]);
        for &size in &sizes {
            svg.text("small", Anchor::Middle, [x(size), ground + 16.0], &size.to_string());
        }
        for curve in &self.curves {
            let points: Vec<_> = curve.points.iter().map(|&(s, f)| [x(s), y(f)]).collect();
            svg.curve(curve.colour, &points);
        }
    }

    fn sizes(&self) -> Vec<u32> {
        let points = self.curves.iter().flat_map(|curve| &curve.points);
        let mut sizes: Vec<u32> = points.map(|&(size, _)| size).collect();
        sizes.sort_unstable();
        sizes.dedup();
        sizes
    }

    /// Lowest and highest figure of the curves.
    pub fn range(&self) -> Option<[f64; 2]> {
        let figures = || self.curves.iter().flat_map(|curve| &curve.points).map(|&(_, f)| f);
        let low = figures().reduce(f64::min)?;
        Some([low, figures().reduce(f64::max)?])
    }
}

/// Where `value` lies between `low` and `high` on a logarithmic axis; the middle where they meet.
fn share(value: f64, low: f64, high: f64) -> f64 {
    let width = (high / low).ln();
    if width > 0.0 { (value / low).ln() / width } else { 0.5 }
}

/// 1, 2 and 5 times powers of ten from `low` to `high`; every power alone where those are many.
pub fn ticks(low: f64, high: f64) -> Vec<f64> {
    let decades = (low.log10().floor() as i32)..=(high.log10().ceil() as i32);
    let few = decades.clone().count() <= 4;
    let steps: &[f64] = if few { &[1.0, 2.0, 5.0] } else { &[1.0] };
    // Powers of ten by division where they are below 1, so that they print as 0.1.
    let power = |d: i32, m: f64| if d < 0 { m / 10f64.powi(-d) } else { m * 10f64.powi(d) };
    let all = decades.flat_map(|d| steps.iter().map(move |&m| power(d, m)));
    all.filter(|tick| (low * 0.999..=high * 1.001).contains(tick)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::svg::is_well_formed;
    use super::*;

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks(0.5, 12.0), [0.5, 1.0, 2.0, 5.0, 10.0]);
        assert_eq!(ticks(0.1, 3000.0), [0.1, 1.0, 10.0, 100.0, 1000.0]);
    }

    #[test]
    fn a_panel_holds_its_curves() {
        let curve = Curve { colour: "#000", points: vec![(512, 8.0), (1024, 4.0), (4096, 1.0)] };
        let panel = Panel { title: "fbm", curves: vec![curve] };
        assert_eq!(panel.range(), Some([1.0, 8.0]));
        let mut svg = Svg::new(PANEL[0], PANEL[1]);
        panel.draw(&mut svg, [0.0, 0.0], [1.0, 10.0]);
        let text = svg.finish("t");
        assert!(is_well_formed(&text), "{text}");
        // The first point stands at the left, log10(8) of the way up.
        let y = TOP + INSIDE[1] * (1.0 - 8f64.log10());
        assert!(text.contains(&format!("cx=\"{LEFT:.1}\" cy=\"{y:.1}\"")), "{text}");
        for label in ["512", "4096", ">10<", "fbm"] {
            assert!(text.contains(label), "{label}");
        }
    }

    #[test]
    fn a_single_size_stands_in_the_middle() {
        let curve = Curve { colour: "#000", points: vec![(512, 8.0)] };
        let mut svg = Svg::new(PANEL[0], PANEL[1]);
        Panel { title: "x", curves: vec![curve] }.draw(&mut svg, [0.0, 0.0], [8.0, 8.0]);
        assert!(!svg.finish("t").contains("NaN"));
    }
}

//! [`Svg`]: the few shapes that plots are made of, as text.
//!
//! Colours come from classes whose style follows the reader's light or dark theme.

use std::fmt::Write;

/// A picture in the making; coordinates in pixels, y downwards.
pub struct Svg {
    width: f64,
    height: f64,
    body: String,
}

/// Where a text begins, ends or has its middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// Ink and lines of both themes; the colours of contenders are readable on either.
const STYLE: &str = "\
text{font:12px system-ui,sans-serif;fill:#333}.title{font-size:14px;font-weight:600}\
.small{font-size:11px}.axis{stroke:#888;stroke-width:1}.grid{stroke:#8884;stroke-width:1}\
.curve{fill:none;stroke-width:2}\
@media(prefers-color-scheme:dark){text{fill:#ddd}}";

impl Svg {
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// The whole file.
    pub fn finish(self, title: &str) -> String {
        let Self { width, height, body } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\">\n<title>{}</title>\n\
             <style>{STYLE}</style>\n{body}</svg>\n",
            escaped(title)
        )
    }

    pub fn line(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        self.put(format_args!(
            "<line class=\"{class}\" x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
            from[0], from[1], to[0], to[1]
        ));
    }

    /// A line through points, with a dot at each.
    pub fn curve(&mut self, colour: &str, points: &[[f64; 2]]) {
        let list: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        self.put(format_args!(
            "<polyline class=\"curve\" stroke=\"{colour}\" points=\"{}\"/>",
            list.join(" ")
        ));
        for [x, y] in points {
            self.put(format_args!(
                "<circle fill=\"{colour}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>"
            ));
        }
    }

    /// A filled rectangle from a corner to the opposite one.
    pub fn bar(&mut self, colour: &str, from: [f64; 2], to: [f64; 2]) {
        let (x, y) = (from[0].min(to[0]), from[1].min(to[1]));
        let [width, height] = [0, 1].map(|a| (to[a] - from[a]).abs());
        self.put(format_args!(
            "<rect fill=\"{colour}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" \
             height=\"{height:.1}\"/>"
        ));
    }

    pub fn text(&mut self, class: &str, anchor: Anchor, [x, y]: [f64; 2], text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.put(format_args!(
            "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(text)
        ));
    }

    fn put(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "{element}");
    }
}

/// Text without what XML reads as its own.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Whether `text` is well-formed enough: tags nest and close, attributes are quoted.
#[cfg(test)]
pub fn is_well_formed(text: &str) -> bool {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        if rest[..at].contains('>') {
            return false;
        }
        let Some(end) = rest[at..].find('>') else {
            return false;
        };
        let tag = &rest[at + 1..at + end];
        rest = &rest[at + end + 1..];
        let name = tag.trim_matches('/').split_whitespace().next().unwrap_or("");
        let quotes = tag.matches('"').count();
        if !quotes.is_multiple_of(2) || name.is_empty() {
            return false;
        }
        match (tag.starts_with('/'), tag.ends_with('/')) {
            (true, _) if open.pop() != Some(name) => return false,
            (false, false) => open.push(name),
            _ => {}
        }
    }
    open.is_empty() && !rest.contains('>')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_make_a_well_formed_file() {
        let mut svg = Svg::new(100.0, 50.0);
        svg.line("axis", [0.0, 0.0], [1.0, 1.0]);
        svg.curve("#123456", &[[0.0, 1.0], [2.0, 3.0]]);
        svg.bar("#123456", [5.0, 5.0], [1.0, 9.0]);
        svg.text("small", Anchor::End, [1.0, 2.0], "a < b & \"c\"");
        let text = svg.finish("x > y");
        assert!(is_well_formed(&text), "{text}");
        assert!(text.contains("a &lt; b &amp; &quot;c&quot;"));
        assert!(text.contains("x=\"1.0\" y=\"5.0\" width=\"4.0\" height=\"4.0\""));
    }

    #[test]
    fn the_judge_of_form_sees_what_is_wrong() {
        for bad in ["<a>", "<a></b>", "<a b=\"c></a>", "</a>", "a > b", "<a><b></a></b>"] {
            assert!(!is_well_formed(bad), "{bad}");
        }
        assert!(is_well_formed("<a b=\"c\"><d/>e</a>"));
    }
}

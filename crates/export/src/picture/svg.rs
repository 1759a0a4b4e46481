//! Plain SVG: elements, numbers, texts and their width.

use crate::xml::escape;
use std::fmt::Write;

/// Fonts; every system has one of them.
const FONTS: &str = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";

/// A drawing.
pub struct Svg {
    text: String,
}

/// Alignment of a text to its position.
#[derive(Clone, Copy, PartialEq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// Position and style of a text.
#[derive(Clone, Copy)]
pub struct Text<'a> {
    pub x: f64,
    /// Baseline.
    pub y: f64,
    pub size: f64,
    pub fill: &'a str,
    pub weight: u32,
    pub anchor: Anchor,
    pub class: &'a str,
    /// Rotated by a quarter turn to the left.
    pub upright: bool,
}

impl Text<'_> {
    pub fn at(x: f64, y: f64) -> Self {
        Self { x, y, size: 11.0, fill: "#222222", weight: 400, anchor: Anchor::Start, class: "", upright: false }
    }
}

impl Svg {
    /// An empty page of `size` units, four to the millimetre.
    pub fn page(size: [f64; 2], title: &str) -> Self {
        let [w, h] = size;
        let text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"{FONTS}\">\n<title>{}</title>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n",
            w / 4.0,
            h / 4.0,
            escape(title)
        );
        Self { text }
    }

    pub fn open(&mut self, attributes: &str) {
        let _ = writeln!(self.text, "<g {attributes}>");
    }

    pub fn close(&mut self) {
        self.text.push_str("</g>\n");
    }

    /// `element` is written as it is: its text must be escaped.
    pub fn raw(&mut self, element: &str) {
        self.text.push_str(element);
        self.text.push('\n');
    }

    pub fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], style: &str) {
        let (x1, y1, x2, y2) = (number(x1), number(y1), number(x2), number(y2));
        let _ = writeln!(self.text, "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {style}/>");
    }

    pub fn rect(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], style: &str) {
        let (x, y, w, h) = (number(x), number(y), number(w), number(h));
        let _ = writeln!(self.text, "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {style}/>");
    }

    pub fn text(&mut self, place: &Text<'_>, content: &str) {
        let (x, y) = (number(place.x), number(place.y));
        let _ = write!(self.text, "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\"", place.size, place.fill);
        if place.weight != 400 {
            let _ = write!(self.text, " font-weight=\"{}\"", place.weight);
        }
        match place.anchor {
            Anchor::Start => {}
            Anchor::Middle => self.text.push_str(" text-anchor=\"middle\""),
            Anchor::End => self.text.push_str(" text-anchor=\"end\""),
        }
        if !place.class.is_empty() {
            let _ = write!(self.text, " class=\"{}\"", place.class);
        }
        if place.upright {
            let _ = write!(self.text, " transform=\"rotate(-90 {x} {y})\"");
        }
        let _ = writeln!(self.text, ">{}</text>", escape(content));
    }

    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// A coordinate of the page: two decimals, no trailing zeros, no minus zero.
pub fn number(value: f64) -> String {
    let mut text = format!("{value:.2}");
    text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    if text == "-0" { "0".into() } else { text }
}

/// Three significant digits.
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..7.0).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    format!("{value:.*}", (2.0 - magnitude).max(0.0) as usize)
}

/// A length (m) with its unit.
pub fn length(value: f64) -> String {
    if value.abs() < 1.0 { format!("{} mm", significant(1e3 * value)) } else { format!("{} m", significant(value)) }
}

/// Width of a text in page units, on the wide side for the fonts named above.
pub fn width(text: &str, size: f64) -> f64 {
    let em: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | 't' | 'f' | 'r' | ' ' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | '(' | ')' => 0.37,
            'm' | 'w' | 'M' | 'W' | '@' | '%' => 0.98,
            '<' | '>' | '=' | '+' | '~' | '&' | '#' => 0.84,
            'A'..='Z' => 0.74,
            c if (c as u32) < 0x2e80 => 0.63,
            _ => 1.05,
        })
        .sum();
    em * size
}

/// `text`, shortened with an ellipsis to what fits into `space`.
pub fn fitted(text: &str, size: f64, space: f64) -> String {
    if width(text, size) <= space {
        return text.into();
    }
    let mut out = String::new();
    for c in text.chars() {
        out.push(c);
        if width(&out, size) + size > space {
            out.pop();
            break;
        }
    }
    out.push('…');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(100.0), "100");
        assert_eq!(number(1.505), "1.5");
        assert_eq!(significant(0.05234), "0.0523");
        assert_eq!(significant(523.4), "523");
        assert_eq!(length(0.0523), "52.3 mm");
        assert_eq!(length(1.0), "1.00 m");
    }

    #[test]
    fn long_words_are_cut() {
        assert_eq!(fitted("short", 10.0, 100.0), "short");
        let cut = fitted(&"long".repeat(100), 10.0, 100.0);
        assert!(cut.ends_with('…') && width(&cut, 10.0) <= 105.0, "{cut}");
    }
}

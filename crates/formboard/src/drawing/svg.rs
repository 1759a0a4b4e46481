//! SVG for the screen: one user unit is a millimetre.

use super::Drawing;
use super::scene::{Anchor, Layer, Shape, scene};
use crate::line::{Line, Point};
use std::fmt::Write as _;
use std::io::{self, Write};

/// Room around the board, mm.
const AROUND: f64 = 20.0;

/// Writes the drawing.
///
/// # Errors
/// Those of `out`.
pub fn svg(drawing: &Drawing<'_>, out: &mut dyn Write) -> io::Result<()> {
    let [width, height] = drawing.board.size.map(|x| x * 1e3);
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" viewBox=\"{2} {2} {0} {1}\" \
         font-family=\"sans-serif\">\n<title>{3}</title>",
        round(width + 2.0 * AROUND),
        round(height + 2.0 * AROUND),
        -AROUND,
        escape(drawing.title)
    )?;
    writeln!(
        out,
        "<rect x=\"{0}\" y=\"{0}\" width=\"{1}\" height=\"{2}\" fill=\"white\"/>",
        -AROUND,
        round(width + 2.0 * AROUND),
        round(height + 2.0 * AROUND)
    )?;
    let shapes = scene(drawing);
    let page = Page { height };
    for layer in Layer::ALL {
        let [r, g, b] = layer.colour();
        let colour = format!("#{r:02x}{g:02x}{b:02x}");
        writeln!(out, "<g id=\"{}\" stroke=\"{colour}\" fill=\"none\" stroke-width=\"0.35\">", layer.name())?;
        for (_, shape) in shapes.iter().filter(|(own, _)| *own == layer) {
            page.write(shape, &colour, out)?;
        }
        writeln!(out, "</g>")?;
    }
    writeln!(out, "</svg>")
}

/// y runs downwards in SVG.
struct Page {
    height: f64,
}

impl Page {
    fn point(&self, p: Point) -> String {
        format!("{} {}", round(p.x), round(self.height - p.y))
    }

    fn write(&self, shape: &Shape, colour: &str, out: &mut dyn Write) -> io::Result<()> {
        match shape {
            Shape::Cable { line, width } => {
                let path = self.path(line);
                writeln!(out, "<path d=\"{path}\" stroke-width=\"{}\" stroke-opacity=\"0.75\"/>", round(*width))
            }
            Shape::Segment(a, b) => writeln!(out, "<path d=\"M{} L{}\"/>", self.point(*a), self.point(*b)),
            Shape::Circle { centre, radius } => {
                let (x, y) = (round(centre.x), round(self.height - centre.y));
                writeln!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"/>")
            }
            Shape::Polygon(points) => {
                let points: Vec<String> = points.iter().map(|p| self.point(*p)).collect();
                writeln!(out, "<path d=\"M{} Z\"/>", points.join(" L"))
            }
            Shape::Text { at, height, turn, anchor, text } => {
                let anchor = match anchor {
                    Anchor::Left => "start",
                    Anchor::Middle => "middle",
                    Anchor::Right => "end",
                };
                let place = self.point(*at);
                let turn = round(-turn.to_degrees());
                let turned = if turn == 0.0 { String::new() } else { format!(" transform=\"rotate({turn} {place})\"") };
                let (x, y) = place.split_once(' ').unwrap_or_default();
                writeln!(
                    out,
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" stroke=\"none\" \
                     fill=\"{colour}\"{turned}>{}</text>",
                    // Capitals have 0.72 of the font's size.
                    round(height / 0.72),
                    escape(text)
                )
            }
            Shape::Dimension { .. } => {
                shape.dimension_parts().iter().try_for_each(|part| self.write(part, colour, out))
            }
        }
    }

    fn path(&self, line: &Line) -> String {
        let mut path = format!("M{}", self.point(line.start));
        if line.curvature == 0.0 {
            let _ = write!(path, " L{}", self.point(line.end()));
            return path;
        }
        // Two halves: an arc of more than half a turn would be drawn the short way.
        let radius = round(1.0 / line.curvature.abs());
        let sweep = u8::from(line.curvature < 0.0);
        for s in [0.5, 1.0].map(|part| part * line.length) {
            let _ = write!(path, " A{radius} {radius} 0 0 {sweep} {}", self.point(line.at(s)));
        }
        path
    }
}

/// To a micrometre, without a negative zero.
fn round(x: f64) -> f64 {
    (x * 1e3).round() / 1e3 + 0.0
}

/// Text for content. Characters that XML cannot hold become U+FFFD.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

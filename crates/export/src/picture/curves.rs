//! Measured curves and the computed ones over them, one colour for each.

use super::overlay::colour;
use super::svg::{Anchor, Svg, Text, fitted, number};
use std::io::{self, Write};

/// Size of the page, page units.
const PAGE: [f64; 2] = [760.0, 460.0];
/// Left, upper, right and lower edge of the plot.
const EDGES: [f64; 4] = [70.0, 50.0, 740.0, 410.0];
/// Height of a row of the legend.
const ROW: f64 = 17.0;
/// Number of measured points of a curve that are drawn.
const POINTS: usize = 120;

/// A curve: deflection, mm, and load, N.
#[derive(Clone, Debug)]
pub struct MeasuredCurve {
    /// Words of the legend.
    pub words: String,
    /// What was measured.
    pub measured: Vec<[f64; 2]>,
    /// What was computed.
    pub computed: Vec<[f64; 2]>,
}

/// Writes a picture of bending curves: circles measured, lines computed.
///
/// # Errors
/// Those of `out`.
pub fn write_curves(curves: &[MeasuredCurve], title: &str, out: &mut impl Write) -> io::Result<()> {
    out.write_all(draw(curves, title).as_bytes())
}

/// Distance of the lines of an axis: 1, 2 or 5 times a power of ten, for about six of them.
fn spacing(range: f64) -> f64 {
    let rough = range / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * power).find(|step| *step >= rough).unwrap_or(power)
}

fn draw(curves: &[MeasuredCurve], title: &str) -> String {
    let [left, upper, right, lower] = EDGES;
    let all = || curves.iter().flat_map(|own| own.measured.iter().chain(&own.computed));
    let most = |axis: usize| all().map(|point| point[axis]).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let least = all().map(|point| point[1]).fold(0.0, f64::min);
    let (width, height) = (1.02 * most(0), 1.05 * (most(1) - least));
    let place = |[x, y]: [f64; 2]| [left + (right - left) * x / width, lower - (lower - upper) * (y - least) / height];
    let mut page = Svg::page(PAGE, title);
    page.text(&Text { size: 18.0, weight: 700, ..Text::at(left, 30.0) }, &fitted(title, 18.0, right - left));
    let grid = "stroke=\"#dddddd\" stroke-width=\"0.8\"";
    let lines = |range: f64| {
        let step = spacing(range);
        (0..=(range / step) as usize).map(move |k| step * k as f64)
    };
    for x in lines(width) {
        let [at, _] = place([x, 0.0]);
        page.line([at, upper], [at, lower], grid);
        page.text(&Text { anchor: Anchor::Middle, ..Text::at(at, lower + 16.0) }, &number(x));
    }
    for y in lines(height + least) {
        let [_, at] = place([0.0, y]);
        page.line([left, at], [right, at], grid);
        page.text(&Text { anchor: Anchor::End, ..Text::at(left - 6.0, at + 4.0) }, &number(y));
    }
    page.text(&Text { anchor: Anchor::End, ..Text::at(right, lower + 34.0) }, "deflection, mm");
    page.text(&Text::at(12.0, upper - 8.0), "load, N");
    for (k, curve) in curves.iter().enumerate() {
        let stroke = colour(k);
        for point in curve.measured.iter().step_by((curve.measured.len() / POINTS).max(1)) {
            let [x, y] = place(*point).map(number);
            page.raw(&format!(
                "<circle class=\"measured\" cx=\"{x}\" cy=\"{y}\" r=\"2\" fill=\"none\" stroke=\"{stroke}\"/>"
            ));
        }
        let line: Vec<String> = curve.computed.iter().map(|point| place(*point).map(number).join(",")).collect();
        page.raw(&format!(
            "<polyline class=\"computed\" points=\"{}\" fill=\"none\" stroke=\"{stroke}\" stroke-width=\"1.8\"/>",
            line.join(" ")
        ));
    }
    let words = curves.iter().map(|own| own.words.as_str()).chain(["line: computed; circle: measured"]);
    for (k, words) in words.enumerate() {
        let y = upper + ROW * (k as f64 + 0.7);
        if k < curves.len() {
            page.line(
                [left + 10.0, y - 4.0],
                [left + 30.0, y - 4.0],
                &format!("stroke=\"{}\" stroke-width=\"3\"", colour(k)),
            );
        }
        page.text(&Text::at(left + 38.0, y), &fitted(words, 11.0, right - left - 50.0));
    }
    page.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_numbers() {
        assert_eq!([12.0, 0.9, 6.1, 250.0].map(spacing), [2.0, 0.2, 2.0, 50.0]);
    }
}

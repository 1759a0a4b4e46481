//! Curves along a branch, as SVG.

use super::layout::fixed;
use crate::ending::BranchEnd;
use crate::local::Local;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use wireloom_core::equilibrium::BranchResult;
use wireloom_core::sections::SectionResult;

const SIZE: (u32, u32) = (560, 230);
/// The last curve is drawn over the others.
const LAST: RGBColor = RGBColor(0x1f, 0x5f, 0xa8);
const OTHER: RGBColor = RGBColor(0xc4, 0x6a, 0x00);
const PASS: RGBColor = RGBColor(0x14, 0x63, 0x2b);
const LIMIT: RGBColor = RGBColor(0x8b, 0x00, 0x19);
/// End of the axis of bend radii, in units of the smallest one (or the limit).
const STRAIGHT: f64 = 30.0;

/// Bend radius (mm, on a logarithmic scale) along each curve, the last one on top, and its limits.
pub fn bend_radius(curves: &[&BranchResult]) -> String {
    let limits = curves.last().map_or_else(Vec::new, |branch| limits_of(branch));
    let limit = limits.iter().map(|[_, _, limit]| *limit).reduce(f64::max);
    let all = || curves.iter().flat_map(|branch| &branch.bend_radius).copied().filter(|r| r.is_finite() && *r > 0.0);
    let least = limits.iter().map(|[_, _, limit]| *limit).chain(all()).fold(f64::INFINITY, f64::min);
    // Straight everywhere and without limit: any scale will do.
    let least = if least.is_finite() { 1e3 * least } else { 1e3 };
    let most = STRAIGHT * limit.map_or(least, |limit| (1e3 * limit).max(least));
    let values = |branch: &BranchResult| -> Vec<f64> {
        branch.bend_radius.iter().map(|r| if r.is_nan() { most } else { (1e3 * r).clamp(0.5 * least, most) }).collect()
    };
    draw(&lines(curves, values), (0.8 * least..most).log_scale(), &short, &limits)
}

/// Arc lengths between which a smallest bend radius is allowed, and that radius, m.
fn limits_of(branch: &BranchResult) -> Vec<[f64; 3]> {
    if branch.sections.is_empty() {
        let end = branch.s.last().copied().unwrap_or_default();
        return branch.bend_radius_limit.map(|limit| [0.0, end, limit]).into_iter().collect();
    }
    let part = |part: &SectionResult| part.bend_radius_limit.map(|limit| [part.from, part.to, limit]);
    branch.sections.iter().filter_map(part).collect()
}

/// Bend radius (mm, on a logarithmic scale) along several shapes of a branch, each in its colour (`#rrggbb`).
pub fn bend_radii(curves: &[(&BranchEnd, &str)]) -> String {
    let all = curves.iter().flat_map(|(branch, _)| &branch.bend_radius).copied();
    let least = all.filter(|r| r.is_finite() && *r > 0.0).fold(f64::INFINITY, f64::min);
    let least = if least.is_finite() { 1e3 * least } else { 1e3 };
    let most = STRAIGHT * least;
    let line = |(branch, colour): &(&BranchEnd, &str)| {
        let radius = |r: &f64| if r.is_nan() { most } else { (1e3 * r).clamp(0.5 * least, most) };
        let points = branch.s.iter().map(|s| 1e3 * s).zip(branch.bend_radius.iter().map(radius)).collect();
        Line { points, colour: rgb(colour) }
    };
    let lines: Vec<Line> = curves.iter().map(line).collect();
    draw(&lines, (0.8 * least..most).log_scale(), &short, &[])
}

/// A curve and its colour.
struct Line {
    points: Vec<(f64, f64)>,
    colour: RGBColor,
}

/// Values along each curve, the last one on top.
fn lines(curves: &[&BranchResult], values: impl Fn(&BranchResult) -> Vec<f64>) -> Vec<Line> {
    let line = |(k, branch): (usize, &&BranchResult)| Line {
        points: branch.s.iter().map(|s| 1e3 * s).zip(values(branch)).collect(),
        colour: if k + 1 == curves.len() { LAST } else { OTHER },
    };
    curves.iter().enumerate().map(line).collect()
}

/// Colour of `#rrggbb`.
fn rgb(hex: &str) -> RGBColor {
    let part = |k: usize| hex.get(k..k + 2).and_then(|part| u8::from_str_radix(part, 16).ok()).unwrap_or(0);
    RGBColor(part(1), part(3), part(5))
}

/// Tension (N) along each curve.
pub fn tension(curves: &[&BranchResult]) -> String {
    let values = |branch: &BranchResult| -> Vec<f64> {
        let at = |i: usize| Local::at(branch, i).tension;
        (0..branch.s.len()).map(at).map(|t| if t.is_finite() { t } else { 0.0 }).collect()
    };
    let all: Vec<f64> = curves.iter().flat_map(|branch| values(branch)).collect();
    let (low, high) = all.iter().fold((0.0_f64, 0.0_f64), |(low, high), t| (low.min(*t), high.max(*t)));
    let margin = (0.08 * (high - low)).max(1e-3);
    // Two digits more than the size of the range has.
    let digits = (1.5 - (high - low + margin).log10()).ceil().clamp(0.0, 9.0) as usize;
    draw(&lines(curves, values), low - margin..high + margin, &|t| fixed(t, digits), &[])
}

/// Curves over s (mm), and limits between two arc lengths, m.
fn draw<Y>(lines: &[Line], y: Y, words: &dyn Fn(f64) -> String, limits: &[[f64; 3]]) -> String
where
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut text = String::new();
    let length = lines.iter().filter_map(|line| line.points.last()).fold(0.0_f64, |a, (s, _)| a.max(*s)).max(1e-6);
    let attempt = || -> Result<(), Box<dyn std::error::Error + '_>> {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(|error| error.to_string())?;
        let mut chart = ChartBuilder::on(&area)
            .margin(6)
            .margin_right(14)
            .x_label_area_size(24)
            .y_label_area_size(58)
            .build_cartesian_2d(0.0..length, y)
            .map_err(|error| error.to_string())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .label_style(("sans-serif", 13))
            .y_labels(10)
            .x_label_formatter(&|x| short(*x))
            .y_label_formatter(&|y| words(*y))
            .draw()
            .map_err(|error| error.to_string())?;
        for [from, to, limit] in limits.iter().map(|own| own.map(|metres| 1e3 * metres)) {
            let line = [(from, limit), (to, limit)];
            chart
                .draw_series(DashedLineSeries::new(line, 6, 4, LIMIT.stroke_width(2)))
                .map_err(|error| error.to_string())?;
        }
        for Line { points, colour } in lines {
            let series = LineSeries::new(points.iter().copied(), colour.stroke_width(2));
            chart.draw_series(series).map_err(|error| error.to_string())?;
        }
        area.present().map_err(|error| error.to_string())?;
        Ok(())
    };
    match attempt() {
        Ok(()) => text,
        // Writing to a string cannot fail; a plot that cannot be drawn is omitted.
        Err(_) => String::new(),
    }
}

/// Histogram with bars of equal width.
pub fn histogram(values: &[f64]) -> String {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    if high <= low {
        return String::new();
    }
    // About twenty values a bar, with limits on the number of bars.
    let bars = (values.len() as f64).sqrt().clamp(5.0, 40.0) as usize;
    let width = (high - low) / bars as f64;
    let mut counts = vec![0_u32; bars];
    for x in values {
        counts[(((x - low) / width) as usize).min(bars - 1)] += 1;
    }
    let most = f64::from(counts.iter().copied().max().unwrap_or(1));
    chart((low, high), (0.0, 1.05 * most), |chart| {
        let bars = counts.iter().enumerate().map(|(k, n)| {
            let left = low + k as f64 * width;
            Rectangle::new([(left, 0.0), (left + width, f64::from(*n))], LAST.mix(0.75).filled())
        });
        chart.draw_series(bars).map(|_| ()).map_err(|error| error.to_string())
    })
}

/// Points, and a line through them where they are `joined`.
pub fn response(points: &[(f64, f64)], joined: bool) -> String {
    let range = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) =
            points.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let margin = 0.04 * (high - low);
        (low - margin, high + margin)
    };
    let (x, y) = (range(|point| point.0), range(|point| point.1));
    let sound = |(low, high): (f64, f64)| low.is_finite() && high.is_finite() && high > low;
    if !sound(x) || !sound(y) {
        return String::new();
    }
    chart(x, y, |chart| {
        if joined {
            let line = LineSeries::new(points.iter().copied(), LAST.stroke_width(2));
            chart.draw_series(line).map_err(|error| error.to_string())?;
        }
        let dots = points.iter().map(|point| Circle::new(*point, 2, LAST.mix(0.6).filled()));
        chart.draw_series(dots).map(|_| ()).map_err(|error| error.to_string())
    })
}

/// Verdict of a point in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// It passes.
    Pass,
    /// It fails.
    Fail,
    /// It is unresolved, or nothing was computed.
    Unresolved,
}

/// Points by verdict; those that fail are drawn last.
pub fn region(points: &[(f64, f64, Mark)]) -> String {
    let range = |of: fn(&(f64, f64, Mark)) -> f64| {
        let (low, high) =
            points.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let margin = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1e-9) };
        (low - margin, high + margin)
    };
    let (x, y) = (range(|point| point.0), range(|point| point.1));
    if points.is_empty() || ![x.0, x.1, y.0, y.1].into_iter().all(f64::is_finite) {
        return String::new();
    }
    chart(x, y, |chart| {
        let filled = [(Mark::Pass, PASS.mix(0.7).filled()), (Mark::Unresolved, BLACK.mix(0.8).stroke_width(1))];
        for (mark, style) in filled.into_iter().chain([(Mark::Fail, LIMIT.mix(0.9).filled())]) {
            let dots = points.iter().filter(|point| point.2 == mark);
            let dots = dots.map(|point| Circle::new((point.0, point.1), 3, style));
            chart.draw_series(dots).map_err(|error| error.to_string())?;
        }
        Ok(())
    })
}

/// Axes with plain numbers, and the drawing between them.
type Plane<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn chart(x: (f64, f64), y: (f64, f64), fill: impl FnOnce(&mut Plane<'_, '_>) -> Result<(), String>) -> String {
    let mut text = String::new();
    let attempt = || -> Result<(), String> {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(|error| error.to_string())?;
        let mut chart = ChartBuilder::on(&area)
            .margin(6)
            .margin_right(14)
            .x_label_area_size(24)
            .y_label_area_size(62)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)
            .map_err(|error| error.to_string())?;
        let digits = |(low, high): (f64, f64)| (1.5 - (high - low).log10()).ceil().clamp(0.0, 9.0) as usize;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .label_style(("sans-serif", 13))
            .x_labels(6)
            .y_labels(8)
            .x_label_formatter(&|value| fixed(*value, digits(x)))
            .y_label_formatter(&|value| fixed(*value, digits(y)))
            .draw()
            .map_err(|error| error.to_string())?;
        fill(&mut chart)?;
        area.present().map_err(|error| error.to_string())
    };
    // Writing to a string cannot fail; a plot that cannot be drawn is omitted.
    if attempt().is_ok() { text } else { String::new() }
}

/// `1200`, `0.25`, `3e-5`.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if size < 1e-3 => format!("{value:.0e}"),
        size if size < 1.0 => format!("{value:.3}").trim_end_matches('0').to_owned(),
        size if size < 100.0 => format!("{value:.2}").trim_end_matches('0').trim_end_matches('.').to_owned(),
        _ => format!("{value:.0}"),
    }
}

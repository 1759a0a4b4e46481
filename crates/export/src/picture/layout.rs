//! Places of the three views and the legend on the page, and their common scale.
//!
//! ```text
//! above  | legend
//! -------+-------
//! front  | side
//! ```

use super::view::{Scene, View};

/// A4 landscape, four units to the millimetre.
pub const PAGE: [f64; 2] = [1188.0, 840.0];
/// Margin of the page.
pub const MARGIN: f64 = 36.0;
/// Title and the line under it.
const HEADER: f64 = 54.0;
/// Left of a view: numbers and name of the upward axis.
pub const GUTTER: f64 = 54.0;
/// Under a view: numbers and name of the axis to the right.
pub const FOOTER: f64 = 34.0;
/// Over a view: its caption.
const CAPTION: f64 = 20.0;
/// Between the harness and the frame of its view: room for symbols and names.
const PAD: f64 = 38.0;
/// The legend sets the least width of the right column and the least height of the upper row.
const LEGEND: [f64; 2] = [270.0, 232.0];
/// Least width of the left column and height of the lower row: a straight cable has a view without height.
const LEAST: [f64; 2] = [200.0, 110.0];

/// One view: a rectangle of the page, the world at its centre.
pub struct Panel {
    pub view: View,
    /// Left upper corner.
    pub corner: [f64; 2],
    pub size: [f64; 2],
    /// World coordinates (m) at the middle, along the view's axes.
    pub centre: [f64; 2],
    /// Page units per metre.
    pub scale: f64,
}

impl Panel {
    /// World point to page.
    pub fn place(&self, x: &wireloom_core::Vector) -> [f64; 2] {
        let [a, b] = self.view.axes();
        [
            self.corner[0] + 0.5 * self.size[0] + (x[a] - self.centre[0]) * self.scale,
            self.corner[1] + 0.5 * self.size[1] - (x[b] - self.centre[1]) * self.scale,
        ]
    }
}

/// The page.
pub struct Layout {
    pub panels: [Panel; 3],
    /// Left upper corner and size of the legend.
    pub legend: ([f64; 2], [f64; 2]),
    /// Page units per metre.
    pub scale: f64,
    /// Unit of the axes.
    pub unit: Unit,
}

/// Unit of the axes.
#[derive(Clone, Copy)]
pub struct Unit {
    pub name: &'static str,
    /// Metres in one.
    pub metres: f64,
}

impl Layout {
    pub fn of(scene: &Scene) -> Self {
        let [ex, ey, ez] = scene.size();
        let [cx, cy, cz] = scene.centre();
        let wide = PAGE[0] - 2.0 * MARGIN - 2.0 * GUTTER;
        let high = PAGE[1] - 2.0 * MARGIN - HEADER - 2.0 * (CAPTION + FOOTER);
        let scale = fit(wide, [ex, ey], [LEAST[0], LEGEND[0] - GUTTER]).min(fit(high, [ey, ez], [LEGEND[1], LEAST[1]]));
        let [left, right] = share(wide, scale, [ex, ey], [LEAST[0], LEGEND[0] - GUTTER]);
        let [upper, lower] = share(high, scale, [ey, ez], [LEGEND[1], LEAST[1]]);
        let column = [MARGIN + GUTTER, MARGIN + GUTTER + left + GUTTER];
        let row = [MARGIN + HEADER + CAPTION, MARGIN + HEADER + CAPTION + upper + FOOTER + CAPTION];
        let panel = |view, corner, size, centre| Panel { view, corner, size, centre, scale };
        let unit =
            if ex.max(ey).max(ez) < 3.0 { Unit { name: "mm", metres: 1e-3 } } else { Unit { name: "m", metres: 1.0 } };
        Self {
            panels: [
                panel(View::Above, [column[0], row[0]], [left, upper], [cx, cy]),
                panel(View::Front, [column[0], row[1]], [left, lower], [cx, cz]),
                panel(View::Side, [column[1], row[1]], [right, lower], [cy, cz]),
            ],
            legend: ([column[1] - 0.5 * GUTTER, row[0]], [right + 0.5 * GUTTER, upper]),
            scale,
            unit,
        }
    }
}

/// Largest scale at which two extents, each with padding but not narrower than its least width, fit side by
/// side into `total`.
fn fit(total: f64, extent: [f64; 2], least: [f64; 2]) -> f64 {
    let both = (total - 4.0 * PAD) / (extent[0] + extent[1]);
    for i in 0..2 {
        if extent[i] * both + 2.0 * PAD < least[i] {
            return (total - least[i] - 2.0 * PAD) / extent[1 - i];
        }
    }
    both
}

/// Widths of the two at `scale`; what is left over is divided evenly.
fn share(total: f64, scale: f64, extent: [f64; 2], least: [f64; 2]) -> [f64; 2] {
    let need = [0, 1].map(|i| (extent[i] * scale + 2.0 * PAD).max(least[i]));
    let spare = 0.5 * (total - need[0] - need[1]);
    need.map(|n| n + spare)
}

/// The largest of 1, 2, 5 × 10ᵏ that is not above `value` (> 0).
pub fn round_below(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| d * power <= value * (1.0 + 1e-9)).unwrap_or(1.0);
    digit * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_fit_and_one_touches() {
        for extent in [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.3, 0.01], [0.001, 5.0]] {
            let (total, least) = (1000.0, [200.0, 250.0]);
            let scale = fit(total, extent, least);
            let [a, b] = share(total, scale, extent, least);
            let near = 1e-9;
            assert!((a + b - total).abs() < near && a > least[0] - near && b > least[1] - near, "{extent:?} {a} {b}");
            assert!(a >= extent[0] * scale + 2.0 * PAD - 1e-9 && b >= extent[1] * scale + 2.0 * PAD - 1e-9);
        }
        assert_eq!(fit(1000.0, [0.0, 0.0], [200.0, 250.0]), f64::INFINITY);
    }

    #[test]
    fn round_numbers() {
        for (value, expected) in [(1.0, 1.0), (1.9, 1.0), (2.0, 2.0), (4.9, 2.0), (0.07, 0.05), (999.0, 500.0)] {
            assert!((round_below(value) / expected - 1.0).abs() < 1e-12, "{value}");
        }
    }
}

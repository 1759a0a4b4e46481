//! Pictures of cross-sections: the wires as they pack, within their coverings.

use super::layout::{OPEN, fixed, millimetres};
use maud::{Markup, html};
use nalgebra::Vector2;
use wireloom_core::identity::{CrossSection, WiresOfType};

/// Width of the widest picture, pixels.
const WIDTH: f64 = 240.0;
/// Pixels for each mm at most.
const LARGEST: f64 = 24.0;
/// Fills of the types of wires, in turn.
const FILLS: [&str; 8] = ["#e8b36a", "#8fb8de", "#a9cf8c", "#d99a9a", "#c3a8d8", "#d8d28a", "#8fd0c4", "#c9c9c9"];
/// Angle between the seeds of a sunflower, rad.
const GOLDEN_ANGLE: f64 = 2.399_963;
/// Fraction of a circle that wires fill before they are drawn together.
const LOOSE: f64 = 0.6;
/// Number of pulls towards the middle, the first one as a fraction of the distance, and of pushes after each.
const PULLS: usize = 300;
const PULL: f64 = 0.03;
const PUSHES: usize = 3;
/// Depth at which two wires touch, as a fraction of the radius of the thinnest one.
const TOUCHING: f64 = 1e-3;
/// Number of arrangements of which the smallest is taken, for up to so many wires.
const STARTS: usize = 8;
const MANY: usize = 40;
/// Largest number of wires that are drawn one by one.
const DRAWN: usize = 400;
/// Number of steps towards the centre of the circle around all wires.
const STEPS: usize = 1000;

/// The cross-sections, all to one scale.
pub(super) fn cross_sections(all: &[CrossSection]) -> Markup {
    if all.is_empty() {
        return html! {};
    }
    let packed: Vec<Packed> = all.iter().map(Packed::new).collect();
    let widest = packed.iter().map(|own| own.outer).fold(0.0, f64::max);
    let scale = (WIDTH / widest).min(LARGEST);
    html! {
        section id="cross-sections" {
            h2 { "Cross-sections" }
            p {
                "Wires as they pack by themselves, in the smallest of some arrangements; the dashed circle is what the \
                 rule takes for them, by their fill factor. Coverings lie on the wires as they are drawn; their \
                 diameters are those of the rule. All to one scale."
            }
            details open[all.len() <= OPEN] {
                summary { "Sections of wires (" (all.len()) ")" }
                div class="cross-sections" {
                    @for (own, packed) in all.iter().zip(&packed) { (figure(own, packed, scale)) }
                }
            }
        }
    }
}

/// Wires, packed. Lengths in mm.
struct Packed {
    /// The wires; none where there are too many to draw.
    wires: Vec<Disc>,
    /// Diameter of the circle around all of them; `None`: they are not drawn.
    around: Option<f64>,
    /// Inner and outer diameter of each covering, from the inside: on the wires as they are drawn.
    coverings: Vec<[f64; 2]>,
    /// Diameter of everything.
    outer: f64,
}

impl Packed {
    fn new(section: &CrossSection) -> Self {
        let (wires, around) = match count(section) <= DRAWN {
            true => densest(section),
            false => (Vec::new(), None),
        };
        let mut outer = around.unwrap_or(0.0).max(1e3 * section.wires_diameter);
        let coverings = section.coverings.iter().map(|own| {
            let inner = outer.max(1e3 * own.inner);
            outer = inner + 1e3 * (own.outer - own.inner);
            [inner, outer]
        });
        Self { coverings: coverings.collect(), wires, around, outer }
    }
}

/// The smallest of some arrangements of the wires, and the diameter of the circle around them.
fn densest(section: &CrossSection) -> (Vec<Disc>, Option<f64>) {
    let discs = |(of, own): (usize, &WiresOfType)| {
        std::iter::repeat_n(Disc { of, radius: 500.0 * own.diameter, at: Vector2::zeros() }, own.count)
    };
    let mut wires: Vec<Disc> = section.wires.iter().enumerate().flat_map(discs).collect();
    wires.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let starts = if wires.len() <= MANY { STARTS } else { 1 };
    let mut rng = fastrand::Rng::with_seed(0);
    let (mut best, mut radius) = packed(wires.clone());
    for _ in 1..starts {
        rng.shuffle(&mut wires);
        let (other, smaller) = packed(wires.clone());
        if smaller < radius {
            (best, radius) = (other, smaller);
        }
    }
    (best, Some(2.0 * radius))
}

/// Number of wires.
fn count(section: &CrossSection) -> usize {
    section.wires.iter().map(|own| own.count).sum()
}

/// A wire.
#[derive(Clone, Debug)]
struct Disc {
    /// Its type.
    of: usize,
    radius: f64,
    at: Vector2<f64>,
}

/// These wires, the first one in the middle, drawn together until they touch; and the radius of the circle around them,
/// whose centre is the origin.
fn packed(mut wires: Vec<Disc>) -> (Vec<Disc>, f64) {
    // A spiral of seeds, as in a sunflower.
    let mut area = 0.0;
    for (k, wire) in wires.iter_mut().enumerate() {
        let (sin, cos) = (k as f64 * GOLDEN_ANGLE).sin_cos();
        wire.at = Vector2::new(cos, sin) * (area / LOOSE).sqrt();
        area += wire.radius.powi(2);
    }
    for k in 0..PULLS {
        let pull = 1.0 - PULL * (1.0 - k as f64 / PULLS as f64);
        wires.iter_mut().for_each(|wire| wire.at *= pull);
        for _ in 0..PUSHES {
            push_apart(&mut wires);
        }
    }
    let thinnest = wires.iter().map(|wire| wire.radius).fold(f64::INFINITY, f64::min);
    for _ in 0..PULLS {
        if push_apart(&mut wires) <= TOUCHING * thinnest {
            break;
        }
    }
    let (center, radius) = around(&wires);
    wires.iter_mut().for_each(|wire| wire.at -= center);
    (wires, radius)
}

/// Pushes wires that lie in each other apart, a thin one more than a thick one; returns the largest depth.
fn push_apart(wires: &mut [Disc]) -> f64 {
    let mut deepest = 0.0_f64;
    for i in 1..wires.len() {
        let (before, rest) = wires.split_at_mut(i);
        let one = &mut rest[0];
        for other in before {
            let apart = one.at - other.at;
            let distance = apart.norm();
            let depth = one.radius + other.radius - distance;
            if depth > 0.0 {
                let direction = if distance > 0.0 { apart / distance } else { Vector2::x() };
                let [a, b] = [one.radius.powi(2), other.radius.powi(2)];
                one.at += direction * (depth * b / (a + b));
                other.at -= direction * (depth * a / (a + b));
                deepest = deepest.max(depth);
            }
        }
    }
    deepest
}

/// Centre and radius of the smallest circle around these: steps towards the far side of the farthest, each shorter than
/// the one before (Bădoiu and Clarkson 2003).
fn around(wires: &[Disc]) -> (Vector2<f64>, f64) {
    let reach = |center: &Vector2<f64>, wire: &Disc| (wire.at - center).norm() + wire.radius;
    let farthest = |center: &Vector2<f64>| {
        wires.iter().max_by(|a, b| reach(center, a).total_cmp(&reach(center, b))).expect("a section has wires")
    };
    let mut center = Vector2::zeros();
    for k in 0..STEPS {
        let wire = farthest(&center);
        let away = wire.at - center;
        let length = away.norm();
        if length > 0.0 {
            center += away * ((1.0 + wire.radius / length) / (k + 2) as f64);
        }
    }
    (center, reach(&center, farthest(&center)))
}

fn figure(section: &CrossSection, packed: &Packed, scale: f64) -> Markup {
    let (half, width) = (0.52 * packed.outer, 1.04 * packed.outer * scale);
    let view = format!("{0:.3} {0:.3} {1:.3} {1:.3}", -half, 2.0 * half);
    let label = format!("{} wires in {}", count(section), section.section);
    let size = format!("width: {width:.0}px; height: {width:.0}px");
    html! {
        figure {
            svg viewBox=(view) style=(size) role="img" aria-label=(label) {
                @for (own, [inner, outer]) in section.coverings.iter().zip(&packed.coverings).rev() {
                    circle r=(fixed(0.5 * outer, 3)) fill="#4a4a4a" fill-opacity=(fixed(0.35 + 0.5 * own.share, 2)) {}
                    circle r=(fixed(0.5 * inner, 3)) fill="white" {}
                }
                @for Disc { of, radius, at } in &packed.wires {
                    circle cx=(fixed(at.x, 3)) cy=(fixed(at.y, 3)) r=(fixed(*radius, 3)) fill=(FILLS[of % FILLS.len()])
                        stroke="#333" stroke-width=(fixed(0.8 / scale, 3)) {}
                }
                circle r=(fixed(500.0 * section.wires_diameter, 3)) fill="none" stroke="#000"
                    stroke-width=(fixed(1.0 / scale, 3)) stroke-dasharray=(fixed(5.0 / scale, 3)) {}
            }
            figcaption {
                strong { (section.section) }
                @for (k, own) in section.wires.iter().enumerate() {
                    br; span style=(format!("color: {}", FILLS[k % FILLS.len()])) { "⬤ " }
                    (own.count) " × " (own.kind) ", " (millimetres(own.diameter)) " mm"
                }
                br; "wires " (millimetres(section.wires_diameter)) " mm"
                @match packed.around {
                    Some(around) => { ", packed here " (fixed(around, 1)) " mm" }
                    None => { ", too many to draw" }
                }
                @for own in &section.coverings {
                    br; (own.name) @if own.share < 1.0 { ", " (fixed(100.0 * own.share, 0)) " %" }
                    ", " (millimetres(own.outer)) " mm"
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(wires: &[(usize, f64)]) -> CrossSection {
        let wire = |&(count, diameter): &(usize, f64)| WiresOfType { kind: "wire".to_owned(), count, diameter };
        CrossSection {
            section: "trunk".to_owned(),
            wires: wires.iter().map(wire).collect(),
            wires_diameter: 1e-3,
            coverings: Vec::new(),
        }
    }

    /// One, two, three and seven equal wires: the densest arrangements are known.
    #[test]
    fn few_equal_wires_pack_as_densely_as_can_be() {
        for (count, diameters) in [(1, 1.0), (2, 2.0), (3, 1.0 + 2.0 / 3.0_f64.sqrt()), (7, 3.0)] {
            let around = Packed::new(&section(&[(count, 2e-3)])).around.expect("few wires");
            assert!((around - 2.0 * diameters).abs() < 4e-3, "{count}: {around} mm, not {}", 2.0 * diameters);
        }
    }

    #[test]
    fn a_million_wires_are_not_drawn_one_by_one() {
        let Packed { wires, around, .. } = Packed::new(&section(&[(1_000_000, 1e-3)]));
        assert!(wires.is_empty() && around.is_none());
    }

    /// Wires of a harness lie beside each other, inside the circle, and fill about as much of it as bundles do.
    #[test]
    fn wires_lie_beside_each_other() {
        for wires in [&[(24, 1.6e-3), (2, 3.7e-3), (1, 2.8e-3)][..], &[(80, 1.6e-3), (30, 2.4e-3), (10, 3.7e-3)]] {
            let Packed { wires: packed, around, .. } = Packed::new(&section(wires));
            let around = around.expect("they are drawn");
            assert_eq!(packed.len(), wires.iter().map(|(count, _)| count).sum::<usize>());
            for (k, one) in packed.iter().enumerate() {
                assert!(one.at.norm() + one.radius < 0.5 * around + 1e-9);
                assert_eq!(one.radius, 500.0 * wires[one.of].1);
                for other in &packed[..k] {
                    let gap = (one.at - other.at).norm() - one.radius - other.radius;
                    assert!(gap > -2e-3, "{gap} mm");
                }
            }
            let fill = packed.iter().map(|wire| (2.0 * wire.radius / around).powi(2)).sum::<f64>();
            assert!((0.68..0.8).contains(&fill), "{fill}");
        }
    }
}

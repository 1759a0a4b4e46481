//! Notes on the values of sections by the rule.

use crate::bundle::Between;
use crate::fault::listed;
use crate::scenario::ByRule;
use wireloom_core::Section;

/// A name in quotes: names may contain spaces.
fn quoted(name: &str) -> String {
    format!("\"{name}\"")
}

/// Values of a section by the rule, in one line:
/// `section "trunk", 24 wires under "pvc tape": EI 0.0096 N m² (slip 0.0039, bonded 6.5); …`.
pub(crate) fn note(by_rule: &ByRule, section: &Section) -> String {
    let bundle = &by_rule.bundle;
    let plain = if bundle.wires == 1 { "wire" } else { "wires" };
    let under: Vec<String> = by_rule.made_of.coverings.iter().map(|own| quoted(&own.name)).collect();
    let under = if under.is_empty() { String::new() } else { format!(" under {}", listed(&under)) };
    let measured = |key: &str| by_rule.measured.iter().any(|measured| measured == key);
    let mark = |key: &str| if measured(key) { " measured" } else { "" };
    let stiffness = |key: &str, taken: &[f64], rule: &Between| {
        let value = match taken {
            [a, b] if a != b => format!("[{}, {}]", digits(*a), digits(*b)),
            [a, ..] => digits(*a),
            [] => String::new(),
        };
        let (slip, bonded) = (digits(rule.slip), digits(rule.bonded));
        if !measured(key) {
            return format!("{value} N m² (slip {slip}, bonded {bonded})");
        }
        let outside = taken.iter().any(|x| *x < rule.slip || *x > rule.bonded);
        let position = if outside { "; outside these bounds" } else { "" };
        format!("{value} N m² measured (rule {}; slip {slip}, bonded {bonded}{position})", digits(rule.taken))
    };
    let radius = section.min_bend_radius.unwrap_or_default() * 1e3;
    let tension = section.max_tension.map_or_else(|| "unknown".to_owned(), |tension| format!("{} N", digits(tension)));
    let mut text = format!(
        "section {}, {} {plain}{under}: EI {}; GJ {}; EA {} N{}; diameter {} mm{}; {} g/m{}; bend radius {} mm{}; \
         largest tension {tension}{}",
        quoted(&section.name),
        bundle.wires,
        stiffness("bending_stiffness", &section.bending_stiffness, &bundle.bending),
        stiffness("torsion_stiffness", &[section.torsion_stiffness], &bundle.torsion),
        digits(section.axial_stiffness),
        mark("axial_stiffness"),
        digits(section.diameter * 1e3),
        mark("diameter"),
        digits(section.linear_density * 1e3),
        mark("linear_density"),
        digits(radius),
        mark("min_bend_radius"),
        mark("max_tension"),
    );
    if !section.friction.bending.is_empty() {
        let sticking = digits(section.bending_stiffness[0] + section.friction.diagonal().x);
        text += &format!("; EI {sticking} N m² while its wires stick");
    }
    for remark in &by_rule.remarks {
        text += &format!("; {remark}");
    }
    text
}

/// Two significant digits: the rule is not more accurate.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    if (1e-3..1e4).contains(&rounded.abs()) || rounded == 0.0 { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits() {
        let found = [0.00961, 9.61e-5, 155.2, 1_301_000.0, 9.96, 0.0].map(digits);
        assert_eq!(found, ["0.0096", "9.6e-5", "160", "1.3e6", "10", "0"]);
    }
}

//! Every numeric key reads its least and its greatest value, and refuses what is just beyond them.

use super::SCENARIO;
use crate::format::form::{Form, Key, Keys};
use crate::format::limits::{ANY, DIAMETER, NON_NEGATIVE, POSITIVE, SPAN_LENGTH};
use crate::read::entry::Entry;
use crate::read::files::NoFiles;
use crate::read::reader::Reader;
use crate::read::toml_text::table;
use wireloom_core::{Quantity, Registry};

/// All tables of keys that a scenario may have, each once.
fn tables(from: &'static Keys, found: &mut Vec<&'static Keys>) {
    if found.iter().any(|known| std::ptr::eq(*known, from)) {
        return;
    }
    found.push(from);
    for key in from.keys {
        match key.form {
            Form::Table(inner)
            | Form::Tables(inner)
            | Form::OneOrMoreTables(inner)
            | Form::Named(inner)
            | Form::NamesOrTables(inner) => tables(inner, found),
            _ => {}
        }
    }
}

/// Faults of `key` with the value `text`.
fn faults(keys: &'static Keys, key: &Key, text: &str) -> Vec<crate::Fault> {
    let text = format!("{} = {text}", key.name);
    let parsed = table(&text).unwrap();
    let registry = Registry::default();
    let reader = Reader::new(&text, &NoFiles, &registry);
    let entry = Entry::new(&reader, parsed.get_ref(), 0..0, keys, "it".to_owned());
    let read = match key.form {
        Form::Number(..) => entry.number(key.name).is_some(),
        Form::OneOrTwo(..) => entry.one_or_two(key.name).is_some(),
        Form::Vector(_) => entry.vector(key.name).is_some(),
        Form::Points(_) => entry.points(key.name).is_some(),
        Form::Count(..) => entry.count(key.name).is_some(),
        _ => unreachable!("{} is no number", key.name),
    };
    drop(entry);
    // Faults about other keys do not count here.
    let faults: Vec<_> = reader.finish().into_iter().filter(|fault| !fault.message.contains(" but no ")).collect();
    assert_eq!(read, faults.is_empty(), "{text}: {faults:?}");
    faults
}

/// The value as the key takes it.
fn written(form: Form, x: f64) -> String {
    match form {
        Form::Vector(_) => format!("[0, {x:e}, 0]"),
        Form::Points(_) => format!("[[0, 0, 0], [0, 0, {x:e}]]"),
        Form::OneOrTwo(..) => format!("[{x:e}, {x:e}]"),
        _ => format!("{x:e}"),
    }
}

#[test]
fn every_numeric_key_has_a_least_and_a_greatest_value() {
    let mut all = Vec::new();
    tables(&SCENARIO, &mut all);
    let mut tried = 0;
    for (table, key) in all.into_iter().flat_map(|table| table.keys.iter().map(move |key| (table, key))) {
        if let Form::Count(least, greatest) = key.form {
            for (n, good) in [(least, true), (greatest, true), (greatest + 1, false)] {
                assert_eq!(faults(table, key, &n.to_string()).is_empty(), good, "{} = {n}", key.name);
            }
            let below = faults(table, key, &(least as i64 - 1).to_string());
            assert!(below[0].help.contains(&format!("from {least} to {greatest}")), "{below:?}");
            tried += 1;
        }
        let Some((quantity, bound)) = key.form.bound() else { continue };
        assert!(bound.minimum.is_finite() && bound.maximum.is_finite() && !bound.exclusive, "{}: {bound:?}", key.name);
        assert!(bound.minimum < bound.maximum, "{}: {bound:?}", key.name);
        for good in [bound.minimum, bound.maximum] {
            assert_eq!(faults(table, key, &written(key.form, good)), [], "{} of {}", key.name, table.what);
        }
        for bad in [bound.minimum.next_down(), bound.maximum.next_up(), -f64::MAX, f64::MAX] {
            let found = faults(table, key, &written(key.form, bad));
            // Place, value and correction.
            let (shown, right) = (format!("{bad:e}"), bound.words(quantity));
            assert!(found[0].message.contains(&shown) && found[0].message.contains(key.name), "{found:?}");
            assert_eq!(found[0].help, format!("it must be {right}"));
            assert!(found[0].span.start >= key.name.len() + 3, "{found:?}");
        }
        tried += 1;
    }
    assert!(tried > 80, "{tried} numeric keys");
}

#[test]
fn harnesses_of_micrometres_and_of_kilometres_are_plausible() {
    // A cable of 1 m, 5 mm thick, EA 1e5 N, EI 0.01 N m², 0.1 kg/m, scaled by λ: λ² in stretch and weight, λ⁴ in
    // bending, under gravity that bends it alike.
    for scale in [1e-6, 1.0, 1e4_f64] {
        let all = [
            (Quantity::Length, DIAMETER, 5e-3 * scale),
            (Quantity::Length, SPAN_LENGTH, scale),
            (Quantity::Length, POSITIVE, 1e-3 * scale),
            (Quantity::LinearDensity, NON_NEGATIVE, 0.1 * scale.powi(2)),
            (Quantity::Force, POSITIVE, 1e5 * scale.powi(2)),
            (Quantity::BendingStiffness, POSITIVE, 0.01 * scale.powi(4)),
            (Quantity::Acceleration, ANY, -9.81 / scale),
        ];
        for (quantity, bound, x) in all {
            let of = bound.of(quantity);
            assert!(of.minimum <= x && x <= of.maximum, "{quantity:?} {x:e} at scale {scale}: {of:?}");
        }
    }
}

//! Numbers and names as they are printed.

pub use wireloom::scenario::fault::printable;

/// `21 ms`, `3.2 s`.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 0.1 => format!("{:.1} ms", s * 1e3),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s => format!("{s:.1} s"),
    }
}

/// A number and its noun.
pub fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Items of a finding that are shown.
const ITEMS: usize = 6;

/// A finding, with the first of its items if there are many; `elsewhere`: where all of them are, or nothing.
pub fn found(what: &str, items: &[String], elsewhere: &str) -> String {
    let text = match items {
        [] => what.to_owned(),
        [item] => format!("{what}: {item}"),
        _ if items.len() <= ITEMS => format!("{what} ({} of them): {}", items.len(), items.join(", ")),
        _ => {
            let (shown, more) = (items[..ITEMS].join(", "), items.len() - ITEMS);
            format!("{what} ({} of them): {shown}, and {more} more{elsewhere}", items.len())
        }
    };
    format!("found: {}\n", printable(&text))
}

/// Six significant digits.
pub fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e5).contains(&size) => {
            format!("{value:.*}", (5 - size.log10().floor() as i32).max(0) as usize)
        }
        _ => format!("{value:.5e}"),
    }
}

/// A number and its unit.
pub fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", number(value)).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_two_or_three_digits() {
        assert_eq!([time(2e-5), time(0.0213), time(0.213), time(3.21)], ["20 µs", "21.3 ms", "213 ms", "3.2 s"]);
    }

    #[test]
    fn of_many_items_the_first_are_shown() {
        let items: Vec<String> = (1..=8).map(|k| format!("a{k}")).collect();
        let said = |count: usize| found("odd", &items[..count], " in o");
        assert_eq!([said(0), said(1)], ["found: odd\n", "found: odd: a1\n"]);
        assert_eq!(said(2), "found: odd (2 of them): a1, a2\n");
        assert_eq!(said(8), "found: odd (8 of them): a1, a2, a3, a4, a5, a6, and 2 more in o\n");
    }

    #[test]
    fn numbers_have_six_digits() {
        let shown = [0.0, 0.012, -3.25, 123456.7, 99999.9, 4e-7].map(number);
        assert_eq!(shown, ["0", "0.0120000", "-3.25000", "1.23457e5", "99999.9", "4.00000e-7"]);
    }
}

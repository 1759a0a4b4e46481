//! Numbers, headings of tables and folded sections, the same on all pages.

use maud::{Markup, html};

/// Sections that are open at first; a harness may have hundreds.
pub const OPEN: usize = 12;

/// A length in mm.
pub fn millimetres(metres: f64) -> String {
    fixed(1e3 * metres, 1)
}

/// A bend radius in mm.
pub fn radius(metres: f64) -> String {
    if metres.is_finite() { millimetres(metres) } else { "straight".into() }
}

/// A number with so many decimals, without `-0.000`.
pub fn fixed(value: f64, digits: usize) -> String {
    let scale = 10f64.powi(digits as i32);
    format!("{:.digits$}", (value * scale).round() / scale + 0.0)
}

/// The head of a table; a heading that begins with `>` is that of a column of numbers.
pub fn heading(columns: &[&str]) -> Markup {
    html! {
        thead { tr { @for column in columns { (head(column)) } } }
    }
}

/// One heading; see [`heading`].
pub fn head(column: &str) -> Markup {
    match column.strip_prefix('>') {
        Some(number) => html! { th class="n" { (number) } },
        None => html! { th { (column) } },
    }
}

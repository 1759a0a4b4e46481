//! Units of a file: of SI, imperial ones, products of powers of others, and free names.

use super::{Reader, Xml, child_text, children};
use crate::unit::Product;
use crate::xml::words;
use std::collections::HashMap;

/// Largest number of composite units within each other, and of the factors of one.
const DEPTH: usize = 2;
const FACTORS: usize = 16;

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Unknown units are reported with the values that use them.
    pub(super) fn read_units(&mut self, root: Xml<'a, 'i>) {
        let all: HashMap<&str, Xml> =
            children(root, "Unit").filter_map(|unit| Some((unit.attribute("id")?, unit))).collect();
        for (id, unit) in &all {
            if let Some(known) = product(*unit, &all, DEPTH).and_then(Product::unit) {
                self.file.units.insert(id, known);
            }
        }
    }
}

fn product(unit: Xml, all: &HashMap<&str, Xml>, depth: usize) -> Option<Product> {
    let of = |name| child_text(unit, name);
    let base = match unit.class() {
        "SIUnit" => Product::si(of("SiUnitName")?, of("SiPrefix")),
        "ImperialUnit" => Product::imperial(of("ImperialUnitName")?),
        "USUnit" => Product::imperial(of("UsUnitName")?),
        "CustomUnit" => Product::named(of("Identification")?),
        "OtherUnit" => Some(Product::ONE),
        "CompositeUnit" => {
            let factor = |id: &str| product(*all.get(id)?, all, depth.checked_sub(1)?);
            let factors: Vec<&str> = words(unit, "Factors").take(FACTORS + 1).collect();
            let product = || factors.iter().try_fold(Product::ONE, |so_far, id| so_far.times(factor(id)?));
            if factors.len() > FACTORS { None } else { product() }
        }
        _ => None,
    };
    let exponent = of("Exponent").map_or(Some(1), |text| text.parse().ok())?;
    base?.power(exponent)
}

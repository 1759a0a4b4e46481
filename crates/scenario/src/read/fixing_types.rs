//! Types of constraints: catalogue parts with the freedoms that they hold, their friction and their load limits.

use std::collections::BTreeMap;
use wildmatch::WildMatch;
use wireloom_core::constraint::{Limits, Slide};
use wireloom_core::{HoldWord, Parameters};

/// A type of fixing: a kind of the registry, and values for it. A constraint's own keys take precedence.
#[derive(Clone, Debug)]
pub(crate) struct FixingType {
    /// Short description.
    pub doc: String,
    /// The kind of the registry.
    pub kind: String,
    /// Parameters of that kind.
    pub parameters: Parameters,
    /// The freedoms it holds; `None`: those its kind holds.
    pub hold: Option<Vec<HoldWord>>,
    /// Sliding of the cable through it, if the cable may slide.
    pub slide: Option<Slide>,
    /// Its load limits.
    pub limits: Limits,
    /// Keys that every constraint of the type must give.
    pub needs: Vec<String>,
    /// Part numbers of the type.
    pub parts: Vec<PartNumbers>,
}

/// Part numbers that a type has.
#[derive(Clone, Debug)]
pub(crate) struct PartNumbers {
    /// As the file gives them: a number, or a pattern with `*` and `?`.
    pub text: String,
    /// File, line and column.
    pub place: String,
}

impl PartNumbers {
    /// Whether a part number is among them; spaces do not count.
    pub fn fit(&self, part: &str) -> bool {
        WildMatch::new(&squeezed(&self.text)).matches(&squeezed(part))
    }
}

/// Without spaces.
pub(crate) fn squeezed(part: &str) -> String {
    part.split_whitespace().collect()
}

/// The type of a part number: that which has the number itself, else that with a pattern for it; several are an error,
/// with the names of all and the places of their numbers.
pub(crate) fn of_part<'t>(types: &'t Types, part: &str) -> Result<Option<&'t str>, Vec<(&'t str, &'t PartNumbers)>> {
    let all = types
        .iter()
        .flat_map(|(name, of)| of.iter().flat_map(move |of| of.parts.iter().map(move |p| (name.as_str(), p))));
    let fitting: Vec<(&str, &PartNumbers)> = all.filter(|(_, numbers)| numbers.fit(part)).collect();
    let exact: Vec<_> = fitting.iter().copied().filter(|(_, own)| squeezed(&own.text) == squeezed(part)).collect();
    let found = if exact.is_empty() { fitting } else { exact };
    match found.as_slice() {
        [] => Ok(None),
        [(name, _), rest @ ..] if rest.iter().all(|(other, _)| other == name) => Ok(Some(name)),
        _ => Err(found),
    }
}

/// Types by name; `None` for a faulty one, whose fault has been noted.
pub(crate) type Types = BTreeMap<String, Option<FixingType>>;

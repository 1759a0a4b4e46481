//! Tolerances of the lengths of segments.
//!
//! KBL gives them from version 2.4 on: a `Default_dimension_specification` for all lengths of a type within a range,
//! and a `Dimension_specification` for the distance along certain segments. Both have a `Tolerance_indication` with a
//! `Lower_limit` and an `Upper_limit`, which are deviations ("±5 mm"); some files give the least and the greatest
//! length there instead, and some the lower one without its sign.

use super::{ImportError, LARGEST, Quantity, Reader, Segment, Xml, child, child_text, children, number, title, words};
use std::collections::HashMap;

/// Types of lengths to which a default applies, the more specific one first.
const TYPES: [&str; 2] = ["segment length", "default"];

/// A default.
struct Default {
    /// Lengths to which it applies, m.
    range: [f64; 2],
    limits: [f64; 2],
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Reads the tolerance of every segment: that of its own dimension, or else the first default that applies.
    pub(super) fn read_tolerances(
        &mut self,
        root: Xml<'a, 'i>,
        segments: &mut [Segment],
        index: &HashMap<&'a str, usize>,
    ) -> Result<(), ImportError> {
        let mut defaults = [Vec::new(), Vec::new()];
        for default in children(root, "Default_dimension_specification") {
            let kind = child_text(default, "Tolerance_type").unwrap_or(TYPES[1]);
            let Some(kind) = TYPES.iter().position(|known| *known == kind) else { continue };
            if let (Some(range), Some(limits)) = (self.range(default)?, self.limits(default)?) {
                self.file.keep(default);
                defaults[kind].push(Default { range, limits });
            }
        }
        let mut own: HashMap<usize, [f64; 2]> = HashMap::new();
        for dimension in children(root, "Dimension_specification") {
            let Some(limits) = self.limits(dimension)? else { continue };
            let is_segment = |id: &str| self.file.ids.get(id).is_some_and(|node| node.name() == "Segment");
            match words(dimension, "Segments").collect::<Vec<_>>().as_slice() {
                [one] if index.contains_key(one) => {
                    own.insert(index[one], limits);
                    self.file.keep(dimension);
                }
                // One without wires of the chosen modules.
                [one] if is_segment(one) => {
                    self.file.left_out.insert(dimension.id());
                }
                _ => self
                    .file
                    .findings
                    .add_to("tolerances of dimensions that are not those of one segment; not used", title(dimension)),
            }
        }
        for (k, segment) in segments.iter_mut().enumerate() {
            let Some(length) = segment.physical_length.or(segment.virtual_length) else { continue };
            let applies = |default: &&Default| (default.range[0]..=default.range[1]).contains(&length);
            let default = || defaults.iter().flatten().find(applies).map(|default| default.limits);
            let Some(limits) = own.get(&k).copied().or_else(default) else { continue };
            segment.tolerance = deviations(limits, length);
            if segment.tolerance.is_none() {
                self.file.findings.add_to("tolerances that leave no length; not used", &segment.id);
            }
        }
        Ok(())
    }

    /// The two limits of the tolerance of a dimension, m; a missing one is 0.
    fn limits(&mut self, dimension: Xml<'a, 'i>) -> Result<Option<[f64; 2]>, ImportError> {
        let Some(tolerance) = child(dimension, "Tolerance_indication") else { return Ok(None) };
        let mut limits = [None; 2];
        for (limit, name) in limits.iter_mut().zip(["Lower_limit", "Upper_limit"]) {
            *limit = self.file.value_within(tolerance, name, Quantity::Length, [-LARGEST, LARGEST])?;
        }
        Ok((limits != [None; 2]).then(|| limits.map(Option::unwrap_or_default)))
    }

    /// The lengths to which a default applies, m; all of them if it gives no range, `None` if that cannot be used.
    fn range(&mut self, default: Xml<'a, 'i>) -> Result<Option<[f64; 2]>, ImportError> {
        let Some(range) = child(default, "Dimension_value_range") else { return Ok(Some([0.0, f64::INFINITY])) };
        let unit = self.file.unit(range);
        let ends = ["Minimum", "Maximum"].map(|name| child(range, name));
        let (Some(unit), [Some(from), Some(to)]) = (unit.filter(|unit| unit.quantity == Quantity::Length), ends) else {
            self.file
                .findings
                .add_to("default tolerances for a range without a unit of length; not used", title(default));
            return Ok(None);
        };
        Ok(Some([number(from, f64::MAX)? * unit.size, number(to, f64::MAX)? * unit.size]))
    }
}

/// Deviations from a length that two limits mean, m; `None` if no length above zero is left.
fn deviations([lower, upper]: [f64; 2], length: f64) -> Option<[f64; 2]> {
    let [least, greatest] = match () {
        // The least and the greatest length.
        () if 0.0 < lower && lower < upper && (lower..=upper).contains(&length) => [lower - length, upper - length],
        // Without signs.
        () if lower > 0.0 && lower >= upper => [-lower, upper],
        () => [lower, upper],
    };
    (least <= greatest && length + least > 0.0).then_some([least, greatest])
}

#[cfg(test)]
mod tests {
    use super::deviations;

    #[test]
    fn limits_are_deviations_or_lengths() {
        assert_eq!(deviations([-0.005, 0.005], 0.5), Some([-0.005, 0.005]));
        assert_eq!(deviations([0.0, 0.01], 0.5), Some([0.0, 0.01]));
        assert_eq!(deviations([0.005, 0.005], 0.5), Some([-0.005, 0.005]));
        assert_eq!(deviations([0.25, 0.75], 0.5), Some([-0.25, 0.25]));
        assert_eq!(deviations([-0.6, 0.0], 0.5), None);
        assert_eq!(deviations([0.002, -0.001], 0.5), Some([-0.002, -0.001]));
        assert_eq!(deviations([0.0, -0.01], 0.5), None);
    }
}

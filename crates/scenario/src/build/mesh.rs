//! The mesh: divides branches into segments such that everything attaches to a node.

use crate::attachment::{At, Stretch};
use crate::scenario::{Branch, Division, Load, Scenario, SectionPart};
use std::collections::BTreeSet;
use wireloom_core::Sections;
use wireloom_core::load::LoadAction;
use wireloom_core::network::{NodeRange, Place};
use wireloom_core::sections::SectionSpan;

/// Fractions of a span that differ by less than this are the same.
const SAME_SHARE: f64 = 1e-12;

/// Division of one branch.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Divided {
    /// Rest length of every segment, m.
    pub rest_lengths: Vec<f64>,
    /// Arc length (m) and node of the ends and of all attachments, increasing.
    pub marks: Vec<(f64, usize)>,
}

impl Divided {
    /// Lengths of the segments of each span between marks, as fractions of the span.
    fn shares(&self) -> Vec<Vec<f64>> {
        let spans = self.marks.windows(2);
        spans
            .map(|pair| {
                let [(from, first), (to, last)] = [pair[0], pair[1]];
                self.rest_lengths[first..last].iter().map(|length| length / (to - from)).collect()
            })
            .collect()
    }

    /// The node at arc length `s`, which must be that of an attachment.
    fn node(&self, s: f64) -> usize {
        let nearest = self.marks.iter().min_by(|a, b| (a.0 - s).abs().total_cmp(&(b.0 - s).abs()));
        nearest.map_or(0, |mark| mark.1)
    }
}

impl Scenario {
    /// The least diameter of a branch, m.
    pub fn thinnest(&self, branch: &Branch) -> f64 {
        branch.sections().map(|section| self.sections[section].diameter).fold(f64::INFINITY, f64::min)
    }

    /// The greatest diameter of a branch, m.
    pub fn diameter(&self, branch: &Branch) -> f64 {
        self.diameter_within(branch, [0.0, branch.length])
    }

    /// The same between two arc lengths, m, both included.
    pub(crate) fn diameter_within(&self, branch: &Branch, [from, to]: [f64; 2]) -> f64 {
        let near = Branch::COINCIDENT * branch.length;
        let spans = branch.section_spans().into_iter();
        let within = spans.filter(|span| span.range[0] <= to + near && span.range[1] >= from - near);
        within.map(|span| self.sections[span.section].diameter).fold(0.0, f64::max)
    }

    /// Gives every branch the mesh of the same branch of `other`: as many segments in each span between attachments,
    /// with the same shares of it, whatever the lengths are now. Returns whether the mesh changes by this. Where
    /// attachments have come to coincide or have separated the division of the branch decides.
    pub fn keep_mesh_of(&mut self, other: &Scenario) -> bool {
        let meshes = Layout::new(self, 1).branches.into_iter().zip(Layout::new(other, 1).branches);
        let mut changes = false;
        for (branch, (own, kept)) in self.branches.iter_mut().zip(meshes) {
            let (own, kept) = (own.shares(), kept.shares());
            let same = |a: &Vec<f64>, b: &Vec<f64>| {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME_SHARE)
            };
            if own.len() != kept.len() || !own.iter().zip(&kept).all(|(a, b)| same(a, b)) {
                branch.shares = kept;
                changes = true;
            }
        }
        changes
    }
}

/// Division and stations of all branches.
pub(crate) struct Layout {
    pub branches: Vec<Divided>,
    /// Nodes with a frame because something attaches there; without the ends of branches.
    pub stations: Vec<BTreeSet<usize>>,
}

impl Layout {
    /// Divides all branches of a scenario; `coarser` segments of the scenario become one.
    pub fn new(scenario: &Scenario, coarser: usize) -> Self {
        let of_constraints = scenario.constraints.iter().flat_map(|constraint| constraint.places());
        let places = of_constraints.chain(scenario.loads.iter().flat_map(Load::places));
        let mut attachments = by_branch(scenario, places);
        let changes =
            |branch: &Branch| -> Vec<f64> { branch.section_spans().iter().skip(1).map(|span| span.range[0]).collect() };
        for (own, branch) in attachments.iter_mut().zip(&scenario.branches) {
            own.extend(changes(branch));
        }
        let sliding = scenario.constraints.iter().filter(|constraint| constraint.slide.is_some());
        let sliding = by_branch(scenario, sliding.map(|constraint| constraint.place()));
        let branches = scenario.branches.iter().zip(attachments).zip(&sliding);
        let branches: Vec<Divided> = branches
            .map(|((branch, attachments), sliding)| {
                divide((branch, scenario.diameter(branch)), attachments, sliding, coarser)
            })
            .collect();
        let mut layout = Self { stations: vec![BTreeSet::new(); branches.len()], branches };
        let of_loads = scenario.loads.iter().filter_map(|load| match load.action {
            LoadAction::At { place, .. } => Some(place),
            LoadAction::Along { .. } => None,
        });
        for at in scenario.constraints.iter().flat_map(|constraint| constraint.at.iter().copied()).chain(of_loads) {
            if let Place::Node { branch, node } = layout.place(at) {
                layout.stations[branch].insert(node);
            }
        }
        for (b, branch) in scenario.branches.iter().enumerate() {
            let nodes = changes(branch).into_iter().map(|s| layout.branches[b].node(s));
            layout.stations[b].extend(nodes);
        }
        layout
    }

    /// The sections of a branch, by segments.
    pub fn sections(&self, scenario: &Scenario, branch: usize) -> Sections {
        let own = &self.branches[branch];
        let span = |span: &SectionPart| SectionSpan {
            section: scenario.sections[span.section].clone(),
            segments: own.node(span.range[0])..own.node(span.range[1]),
        };
        Sections::new(scenario.branches[branch].section_spans().iter().map(span).collect())
    }

    /// The nodes of a span.
    pub fn span(&self, span: &Stretch) -> NodeRange {
        let own = &self.branches[span.branch];
        NodeRange { branch: span.branch, nodes: own.node(span.from)..own.node(span.to) + 1 }
    }

    /// The node or joint of an attachment.
    pub fn place(&self, at: At) -> Place {
        match at {
            At::Joint(joint) => Place::Joint(joint),
            At::Branch { branch, s } => Place::Node { branch, node: self.branches[branch].node(s) },
        }
    }
}

/// Arc lengths of places on each branch, m.
fn by_branch(scenario: &Scenario, places: impl Iterator<Item = At>) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new(); scenario.branches.len()];
    for at in places {
        if let At::Branch { branch, s } = at
            && let Some(own) = all.get_mut(branch)
        {
            own.push(s);
        }
    }
    all
}

/// Divides a branch with attachments at these arc lengths (m), uniformly between neighbouring attachments. A span
/// beside a sliding one has at least two segments: the one at a joint keeps its length.
fn divide((branch, diameter): (&Branch, f64), mut attachments: Vec<f64>, sliding: &[f64], coarser: usize) -> Divided {
    let length = branch.length;
    attachments.sort_by(f64::total_cmp);
    let mut breaks = vec![0.0];
    for s in attachments {
        let last = breaks[breaks.len() - 1];
        if s - last > Branch::COINCIDENT * length && length - s > Branch::COINCIDENT * length {
            breaks.push(s);
        }
    }
    breaks.push(length);
    let spans: Vec<f64> = breaks.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let slides = |s: &f64| sliding.iter().any(|other| (other - s).abs() <= Branch::COINCIDENT * length);
    let least: Vec<usize> = breaks.windows(2).map(|pair| 1 + usize::from(pair.iter().any(slides))).collect();
    if branch.shares.len() == spans.len() {
        return shared(&branch.shares, &breaks, coarser);
    }
    if matches!(branch.division, Division::ByAccuracy { .. }) && !branch.nodes.is_empty() {
        let nodes: Vec<f64> = branch.nodes.iter().map(|fraction| fraction * length).collect();
        return kept(&nodes, &breaks, &least, coarser);
    }
    let up_to = |longest: f64| {
        // A span that is a whole number of segments up to round-off counts as one.
        let whole = |(l, least): (&f64, &usize)| ((l / longest - 1e-9).ceil() as usize).max(*least);
        spans.iter().zip(&least).map(whole).collect()
    };
    let counts: Vec<usize> = match branch.division {
        Division::Segments(segments) => share_out(segments, &spans, &least),
        Division::MaxSegment(longest) => up_to(longest),
        Division::ByAccuracy { longest } if branch.sizes.is_empty() => {
            up_to(longest.min(first_segment(length, diameter)))
        }
        Division::ByAccuracy { longest } => {
            let sizes: Vec<[f64; 2]> = branch.sizes.iter().map(|size| size.map(|fraction| fraction * length)).collect();
            return graded(&sizes, longest, &breaks, &least, coarser);
        }
    };
    let counts: Vec<usize> = counts.into_iter().map(|count| count.div_ceil(coarser)).collect();
    let mut marks = vec![(0.0, 0)];
    let mut rest_lengths = Vec::with_capacity(counts.iter().sum());
    for ((span, count), end) in spans.iter().zip(counts).zip(&breaks[1..]) {
        rest_lengths.extend(std::iter::repeat_n(span / count as f64, count));
        marks.push((*end, rest_lengths.len()));
    }
    Divided { rest_lengths, marks }
}

/// Length (m) of the segments of a branch of this length and diameter (m) before it is known how tightly it bends: an
/// eighth of it or four diameters, and no more than 24 of them.
fn first_segment(length: f64, diameter: f64) -> f64 {
    (length / 8.0).min(4.0 * diameter).max(length / 24.0)
}

/// Divides each span between `breaks` (m) into segments with these shares of it.
fn shared(shares: &[Vec<f64>], breaks: &[f64], coarser: usize) -> Divided {
    let (mut marks, mut rest_lengths) = (vec![(0.0, 0)], Vec::new());
    for (span, shares) in breaks.windows(2).zip(shares) {
        let length = span[1] - span[0];
        rest_lengths.extend(shares.chunks(coarser).map(|some| length * some.iter().sum::<f64>()));
        marks.push((span[1], rest_lengths.len()));
    }
    Divided { rest_lengths, marks }
}

/// Divides spans between `breaks` (m) at these nodes (m); uniformly where they are fewer than `least` asks for.
fn kept(nodes: &[f64], breaks: &[f64], least: &[usize], coarser: usize) -> Divided {
    let near = Branch::COINCIDENT * breaks[breaks.len() - 1];
    let (mut marks, mut rest_lengths) = (vec![(0.0, 0)], Vec::new());
    for (span, least) in breaks.windows(2).zip(least) {
        let [from, to] = [span[0], span[1]];
        let mut ends: Vec<f64> = nodes.iter().copied().filter(|s| *s > from + near && *s < to - near).collect();
        if ends.len() + 1 < *least {
            ends = (1..*least).map(|k| from + (to - from) * k as f64 / *least as f64).collect();
        }
        ends.push(to);
        let count = ends.len().div_ceil(coarser);
        let mut last = from;
        for k in 1..=count {
            let end = ends[k * ends.len() / count - 1];
            rest_lengths.push(end - last);
            last = end;
        }
        marks.push((to, rest_lengths.len()));
    }
    Divided { rest_lengths, marks }
}

/// Divides spans between `breaks` (m) into segments of these lengths: `sizes` are arc lengths and lengths of segments
/// there, m, linear in between. In a span with the integral N of the reciprocal length there are ⌈N⌉ segments, each
/// with the same share of N.
fn graded(sizes: &[[f64; 2]], longest: f64, breaks: &[f64], least: &[usize], coarser: usize) -> Divided {
    let size = |s: f64| {
        let next = sizes.partition_point(|[at, _]| *at <= s);
        let [[a, p], [b, q]] = [next.saturating_sub(1), next.min(sizes.len() - 1)].map(|k| sizes[k]);
        let t = if b > a { ((s - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        (p + (q - p) * t).min(longest)
    };
    let (mut marks, mut rest_lengths) = (vec![(0.0, 0)], Vec::new());
    for (span, least) in breaks.windows(2).zip(least) {
        let [from, to] = [span[0], span[1]];
        let finest = sizes.iter().map(|[_, size]| *size).fold(longest, f64::min);
        // Midpoint rule on pieces much shorter than the shortest segment.
        let pieces = (4.0 * (to - from) / finest).ceil().max(8.0) as usize;
        let piece = (to - from) / pieces as f64;
        let mut sum = vec![0.0];
        for k in 0..pieces {
            sum.push(sum[k] + piece / size(from + (k as f64 + 0.5) * piece));
        }
        let count = ((sum[pieces] - 1e-9).ceil() as usize).max(*least).div_ceil(coarser);
        let at = |share: f64| {
            let k = sum.partition_point(|s| *s <= share).clamp(1, pieces) - 1;
            from + (k as f64 + (share - sum[k]) / (sum[k + 1] - sum[k])) * piece
        };
        let ends: Vec<f64> = (0..=count).map(|k| at(sum[pieces] * k as f64 / count as f64)).collect();
        rest_lengths.extend(ends.windows(2).map(|pair| pair[1] - pair[0]));
        marks.push((to, rest_lengths.len()));
    }
    Divided { rest_lengths, marks }
}

/// Distributes `segments` over spans in proportion to their lengths, at least `least` for each: a further segment
/// goes to the span with the longest segments; an excess one is taken from the span whose segments would remain
/// shortest.
fn share_out(segments: usize, spans: &[f64], least: &[usize]) -> Vec<usize> {
    let length: f64 = spans.iter().sum();
    let share = |span: &f64| (segments as f64 * (span / length)).floor() as usize;
    let mut counts: Vec<usize> = spans.iter().zip(least).map(|(span, least)| share(span).max(*least)).collect();
    loop {
        let total: usize = counts.iter().sum();
        let size = |k: &usize, count: usize| spans[*k] / count as f64;
        if total < segments {
            let longest = (0..spans.len()).max_by(|a, b| size(a, counts[*a]).total_cmp(&size(b, counts[*b])));
            counts[longest.unwrap_or(0)] += 1;
        } else if total > segments {
            let shortest = (0..spans.len())
                .filter(|k| counts[*k] > least[*k])
                .min_by(|a, b| size(a, counts[*a] - 1).total_cmp(&size(b, counts[*b] - 1)));
            let Some(shortest) = shortest else { return counts };
            counts[shortest] -= 1;
        } else {
            return counts;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_spans_make_the_same_mesh_of_other_lengths() {
        let divided = kept(&[0.0, 0.1, 0.3, 0.6, 1.0], &[0.0, 0.3, 1.0], &[1, 1], 1);
        let again = shared(&divided.shares(), &[0.0, 0.3, 1.0], 1);
        assert!(again.rest_lengths.iter().zip(&divided.rest_lengths).all(|(a, b)| (a - b).abs() < 1e-15));
        assert_eq!(again.marks, divided.marks);
        let longer = shared(&divided.shares(), &[0.0, 0.6, 2.0], 1);
        assert!(longer.rest_lengths.iter().zip(&divided.rest_lengths).all(|(a, b)| (a - 2.0 * b).abs() < 1e-15));
        // Two segments become one.
        assert_eq!(shared(&divided.shares(), &[0.0, 0.3, 1.0], 2).marks, [(0.0, 0), (0.3, 1), (1.0, 2)]);
    }

    #[test]
    fn segments_are_shared_out_in_proportion() {
        assert_eq!(share_out(160, &[0.5, 0.7], &[1; 2]), [67, 93]);
        assert_eq!(share_out(10, &[1.0], &[1]), [10]);
        assert_eq!(share_out(3, &[1e-6, 1.0], &[1; 2]), [1, 2]);
        assert_eq!(share_out(1, &[0.5, 0.5], &[1; 2]), [1, 1]);
        assert_eq!(share_out(4, &[1e-6, 1e-6, 1.0], &[1; 3]), [1, 1, 2]);
        assert_eq!(share_out(5, &[0.1, 0.9], &[2; 2]), [2, 3]);
    }

    #[test]
    fn a_graded_mesh_has_the_sizes_asked_for_and_the_ends_of_its_spans() {
        let sizes = [[0.0, 0.01], [0.3, 0.04], [1.0, 0.04]];
        let divided = graded(&sizes, 0.03, &[0.0, 0.25, 1.0], &[1, 1], 1);
        let lengths = &divided.rest_lengths;
        assert!((lengths.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(divided.marks[2], (1.0, lengths.len()));
        let at_mark: f64 = lengths[..divided.marks[1].1].iter().sum();
        assert!((at_mark - 0.25).abs() < 1e-12, "{at_mark}");
        let mut s = 0.0;
        for length in lengths {
            let asked = (0.01 + 0.1 * (s + 0.5 * length)).min(0.03);
            assert!(*length <= asked * 1.01 && *length > 0.6 * asked, "{length} at {s}, not {asked}");
            s += length;
        }
        // Neighbours differ by the growth of the size at most.
        assert!(lengths.windows(2).all(|pair| (0.7..1.4).contains(&(pair[1] / pair[0]))), "{lengths:?}");
    }

    #[test]
    fn kept_nodes_stay_and_attachments_between_them_add_nodes() {
        let nodes = [0.0, 0.1, 0.3, 0.6, 1.0];
        let lengths = |breaks: &[f64], least: &[usize], coarser| kept(&nodes, breaks, least, coarser).rest_lengths;
        let near = |lengths: Vec<f64>, expected: &[f64]| {
            assert!(lengths.len() == expected.len(), "{lengths:?}");
            assert!(lengths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{lengths:?}");
        };
        near(lengths(&[0.0, 1.0], &[1], 1), &[0.1, 0.2, 0.3, 0.4]);
        // At a node up to round-off, and between two nodes.
        near(lengths(&[0.0, 0.3 + 1e-13, 1.0], &[1, 1], 1), &[0.1, 0.2, 0.3, 0.4]);
        near(lengths(&[0.0, 0.5, 1.0], &[1, 1], 1), &[0.1, 0.2, 0.2, 0.1, 0.4]);
        // Beside a ring that slides there are two segments at least.
        near(lengths(&[0.0, 0.1, 1.0], &[2, 2], 1), &[0.05, 0.05, 0.2, 0.3, 0.4]);
        near(lengths(&[0.0, 1.0], &[1], 2), &[0.3, 0.7]);
        assert_eq!(kept(&nodes, &[0.0, 0.5, 1.0], &[1, 1], 1).marks, [(0.0, 0), (0.5, 3), (1.0, 5)]);
    }

    #[test]
    fn the_total_is_what_was_asked_for_wherever_there_are_enough() {
        let mut x = 0.5_f64;
        for n in 3..200 {
            let mut spans = Vec::new();
            for _ in 0..3 {
                x = 3.9 * x * (1.0 - x);
                spans.push(x + 1e-3);
            }
            let counts = share_out(n, &spans, &[1; 3]);
            assert_eq!(counts.iter().sum::<usize>(), n);
            assert!(counts.iter().all(|count| *count > 0));
        }
    }
}

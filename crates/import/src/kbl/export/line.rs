//! The computed centre lines of segments.

use super::computed::{Branch, Computed, Held, JOINED};
use super::error::ExportError;
use crate::curve::{Vector, minimum};
use crate::document::Document;
use crate::findings::Findings;
use crate::kbl::fit;
use nalgebra::UnitQuaternion;
use std::collections::{BTreeMap, HashMap};

/// The branches of a segment, from its start to its end: one, or several where it was split.
pub struct Line<'c> {
    parts: Vec<&'c Branch<'c>>,
    /// m.
    pub length: f64,
    /// Number of nodes of the mesh.
    pub nodes: usize,
    /// The line as a function.
    at: Box<dyn Fn(f64) -> Vector + 'c>,
}

/// The line of every segment that has branches, by the segment's index.
pub fn lines<'c>(
    document: &Document,
    computed: &'c Computed<'c>,
    notes: &mut Findings,
) -> Result<BTreeMap<usize, Line<'c>>, ExportError> {
    let index: HashMap<&str, usize> =
        document.segments.iter().enumerate().map(|(k, segment)| (segment.id.as_str(), k)).collect();
    let (mut parts, mut unknown): (BTreeMap<usize, Vec<&Branch>>, _) = (BTreeMap::new(), Vec::new());
    for branch in &computed.branches {
        match branch.segment.as_deref().map(|id| (id, index.get(id))) {
            None => notes.add_to("branches that come from no segment of the file; not written", &branch.name),
            Some((id, None)) => unknown.push([id.to_owned(), branch.name.clone()]),
            Some((_, Some(segment))) => parts.entry(*segment).or_default().push(branch),
        }
    }
    if !unknown.is_empty() {
        return Err(ExportError::Unknown(unknown));
    }
    if parts.is_empty() {
        return Err(ExportError::NoPartner);
    }
    for (k, segment) in document.segments.iter().enumerate() {
        if !parts.contains_key(&k) {
            notes.add_to("segments without a branch in the result; left as they are", &segment.id);
        }
    }
    parts.into_iter().map(|(k, parts)| Ok((k, Line::of(&document.segments[k].id, parts)?))).collect()
}

impl<'c> Line<'c> {
    /// The branches of a segment in the order in which each begins where the one before ends.
    fn of(segment: &str, mut parts: Vec<&'c Branch<'c>>) -> Result<Self, ExportError> {
        let broken = parts.iter().find(|own| {
            let whole =
                own.s.iter().chain(own.frames.iter().flat_map(|frame| frame.coords.iter())).all(|x| x.is_finite());
            !whole || own.length() <= 0.0 || ![0.0, 0.5, 1.0].iter().all(|f| (own.at)(*f).iter().all(|x| x.is_finite()))
        });
        if let Some(broken) = broken {
            return Err(ExportError::NotFinite(broken.name.clone()));
        }
        let meets = |a: &Branch, b: &Branch| ((a.at)(1.0) - (b.at)(0.0)).norm() <= JOINED;
        for k in 0..parts.len() {
            let next = (k..parts.len()).find(|&j| match k {
                0 => !parts.iter().any(|other| meets(other, parts[j])),
                _ => meets(parts[k - 1], parts[j]),
            });
            let Some(next) = next else {
                let branches = parts.iter().map(|part| part.name.clone()).collect();
                return Err(ExportError::Split { segment: segment.to_owned(), branches });
            };
            parts.swap(k, next);
        }
        let length: f64 = parts.iter().map(|part| part.length()).sum();
        let nodes = parts.iter().map(|part| part.s.len()).sum();
        let own = parts.clone();
        let at = move |f: f64| {
            let mut s = f.clamp(0.0, 1.0) * length;
            for part in &own[..own.len() - 1] {
                if s <= part.length() {
                    return (part.at)(s / part.length());
                }
                s -= part.length();
            }
            let last = own[own.len() - 1];
            (last.at)((s / last.length()).min(1.0))
        };
        Ok(Self { parts, length, nodes, at: Box::new(at) })
    }

    /// Point at a fraction of the length, m.
    pub fn at(&self, f: f64) -> Vector {
        (self.at)(f)
    }

    /// Frames at both ends.
    pub fn frames(&self) -> [UnitQuaternion<f64>; 2] {
        [self.parts[0].frames[0], self.parts[self.parts.len() - 1].frames[1]]
    }

    /// The line for a spline.
    pub fn to_fit(&self) -> fit::Line<'_> {
        let tangents = self.frames().map(|frame| frame * Vector::z());
        fit::Line { at: &*self.at, tangents, length: self.length, nodes: self.nodes }
    }

    /// Names of the branches.
    pub fn names(&self) -> Vec<String> {
        self.parts.iter().map(|part| part.name.clone()).collect()
    }

    /// Name of the branch at the start (0) or the end (1).
    pub fn branch_at(&self, which: usize) -> &str {
        &self.parts[if which == 0 { 0 } else { self.parts.len() - 1 }].name
    }

    /// Least bend radius, m.
    pub fn bend_radius(&self) -> f64 {
        self.parts.iter().map(|part| part.bend_radius).fold(f64::INFINITY, f64::min)
    }

    /// Arc length of the place that a constraint holds, and its distance from the line, m.
    pub fn place_of(&self, held: &Held) -> (f64, f64) {
        let (mut start, mut best) = (0.0, (0.0, f64::INFINITY));
        for part in &self.parts {
            if let Some((_, s)) = held.slides.as_ref().filter(|(branch, _)| *branch == part.name) {
                return (start + s, 0.0);
            }
            let distance = |s: f64| ((part.at)(s / part.length()) - held.position).norm();
            let nearest = (0..part.s.len()).min_by(|&a, &b| distance(part.s[a]).total_cmp(&distance(part.s[b])));
            let k = nearest.unwrap_or_default();
            let s = minimum(part.s[k.saturating_sub(1)], part.s[(k + 1).min(part.s.len() - 1)], distance);
            if distance(s) < best.1 {
                best = (start + s, distance(s));
            }
            start += part.length();
        }
        best
    }
}

impl Branch<'_> {
    /// m.
    fn length(&self) -> f64 {
        self.s.last().copied().unwrap_or(0.0)
    }
}

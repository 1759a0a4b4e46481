//! The tolerance envelope of a sweep, as sent to pages; little-endian:
//!
//! | bytes | what |
//! | --- | --- |
//! | 4 | length n of the header, a multiple of 4 |
//! | n | [`EnvelopeHeader`] as JSON, padded with spaces |
//! | for each tube | mean centre line at its stations (x, y, z), then for each percentile the radii, m: f32 |
//! | 12 per corner | x, y, z of the surface of all that was swept, m: f32 |
//! | 12 per triangle | its corners: u32 |

use crate::frame::number;
use serde::Serialize;
#[cfg(test)]
use ts_rs::TS;
use wireloom::harness::Surface;
use wireloom::sweep::Tube;

/// Content of an envelope.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct EnvelopeHeader {
    /// Its tubes.
    pub tubes: Vec<EnvelopeTube>,
    /// Number of corners of the surface; 0 without one.
    pub corners: u32,
    /// Number of triangles of the surface.
    pub triangles: u32,
}

/// Tubes around a branch at the end of a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct EnvelopeTube {
    /// Name of the branch.
    pub branch: String,
    /// Name of the step.
    pub step: String,
    /// Number of points of the sweep.
    pub points: u32,
    /// Number of stations.
    pub stations: u32,
    /// Percentiles, increasing.
    pub percentiles: Vec<u32>,
}

/// Encodes an envelope; `None` if the lists of a tube, or the corners of a triangle, do not fit.
pub fn encode(tubes: &[Tube], surface: &Surface) -> Option<Vec<u8>> {
    let fits =
        |tube: &Tube| tube.centre.len() > 1 && tube.radii.iter().all(|(_, radii)| radii.len() == tube.centre.len());
    let exists = |triangle: &[u32; 3]| triangle.iter().all(|corner| (*corner as usize) < surface.corners.len());
    if !tubes.iter().all(fits) || !surface.triangles.iter().all(exists) {
        return None;
    }
    let tube = |tube: &Tube| EnvelopeTube {
        branch: tube.branch.clone(),
        step: tube.step.clone(),
        points: number(tube.points),
        stations: number(tube.centre.len()),
        percentiles: tube.radii.iter().map(|(percentile, _)| number(*percentile)).collect(),
    };
    let header = EnvelopeHeader {
        tubes: tubes.iter().map(tube).collect(),
        corners: number(surface.corners.len()),
        triangles: number(surface.triangles.len()),
    };
    let mut head = serde_json::to_vec(&header).ok()?;
    head.resize(head.len().next_multiple_of(4), b' ');
    let mut bytes = [&number(head.len()).to_le_bytes(), head.as_slice()].concat();
    let mut put = |x: f64| bytes.extend((x as f32).to_le_bytes());
    for tube in tubes {
        tube.centre.iter().flatten().for_each(|x| put(*x));
        tube.radii.iter().flat_map(|(_, radii)| radii).for_each(|x| put(*x));
    }
    surface.corners.iter().flatten().for_each(|x| put(*x));
    bytes.extend(surface.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom::geometry::Vector;

    #[test]
    fn an_envelope_whose_lists_do_not_fit_is_not_sent() {
        let tube = Tube {
            branch: "a".to_owned(),
            step: "s".to_owned(),
            points: 7,
            centre: vec![Vector::zeros(), Vector::x()],
            radii: vec![(50, vec![0.1, 0.2])],
        };
        let surface = Surface { corners: vec![Vector::zeros(); 3], triangles: vec![[0, 1, 2]] };
        let bytes = encode(std::slice::from_ref(&tube), &surface).expect("it fits");
        let head = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize;
        assert_eq!(bytes.len(), 4 + head + 4 * (6 + 2) + 12 * 3 + 12);
        let short = Tube { radii: vec![(50, vec![0.1])], ..tube.clone() };
        assert_eq!(encode(&[short], &surface), None);
        assert_eq!(encode(&[tube], &Surface { triangles: vec![[0, 1, 3]], ..surface }), None);
    }
}

//! Harnesses for the tests of stages.

use crate::harness::*;
use crate::memory::Memory;
use crate::plan::Plan;
use fastrand::Rng;
use nalgebra::{DMatrix, Quaternion, Unit, Vector3};

const UNTURNED: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// End of a branch.
#[derive(Clone, Copy)]
pub enum To {
    /// A free end with a point and a station, at this position.
    Free([f64; 3]),
    /// The joint with this number.
    Joint(usize),
}

/// A joint.
#[derive(Clone, Copy)]
struct Joint {
    point: u32,
    hub: Option<u32>,
    at: Vector3<f64>,
}

/// A harness under construction.
pub struct Builder {
    pub harness: Harness,
    pub shape: Shape,
    pub rng: Rng,
    joints: Vec<Joint>,
    /// Arms of each joint: frames of their first segments.
    arms: Vec<Vec<u32>>,
}

pub fn random(rng: &mut Rng, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| size * (2.0 * rng.f64() - 1.0))
}

fn rotation(rng: &mut Rng) -> [f64; 4] {
    let q = Quaternion::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5);
    Unit::new_normalize(q).coords.into()
}

/// A frame whose third axis is `tangent`.
fn along(tangent: &Vector3<f64>) -> Unit<Quaternion<f64>> {
    nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), tangent)
        .unwrap_or_else(|| nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}

impl Builder {
    pub fn new(seed: u64) -> Self {
        Self {
            harness: Harness::default(),
            shape: Shape::default(),
            rng: Rng::with_seed(seed),
            joints: vec![],
            arms: vec![],
        }
    }

    fn point(&mut self, x: &Vector3<f64>) -> u32 {
        self.shape.points.push((*x).into());
        self.shape.compensation.push([0.0; 3]);
        self.harness.dead.push([0.0; 3]);
        self.harness.points += 1;
        self.harness.points as u32 - 1
    }

    fn frame(&mut self, q: [f64; 4]) -> u32 {
        self.shape.frames.push(q);
        self.harness.weights.push(0.0);
        self.harness.frames += 1;
        self.harness.frames as u32 - 1
    }

    pub fn joint(&mut self, at: [f64; 3], hub: bool) -> usize {
        let at = Vector3::from(at);
        let point = self.point(&at);
        let hub = hub.then(|| self.frame(UNTURNED));
        self.joints.push(Joint { point, hub, at });
        self.arms.push(vec![]);
        self.joints.len() - 1
    }

    /// A straight branch of n segments, with stations at free ends, at hubs and at the given nodes.
    pub fn branch(&mut self, n: usize, from: To, to: To, stations: &[usize]) {
        let at = |end: To| match end {
            To::Free(x) => Vector3::from(x),
            To::Joint(j) => self.joints[j].at,
        };
        let (start, end) = (at(from), at(to));
        let length = (end - start).norm() / n as f64;
        let tangent = (end - start).normalize();
        let q: [f64; 4] = along(&tangent).coords.into();
        let (c, ea) = ([0.02, 0.015, 0.01], [400.0, 500.0, 900.0]);
        let mut nodes = vec![];
        let mut ends = vec![];
        for i in 0..=n {
            let x = start + (end - start) * (i as f64 / n as f64);
            let own = [(0, from), (n, to)].into_iter().find(|(node, _)| *node == i).map(|(_, end)| end);
            let (point, station) = match own {
                Some(To::Joint(j)) => {
                    let joint = self.joints[j];
                    let offset: [f64; 3] = if joint.hub.is_some() { [0.01, -0.02, 0.015] } else { [0.0; 3] };
                    let station = joint.hub.map(|frame| Station { frame, rest: q, offset, blend: 0.125 });
                    (joint.point, station)
                }
                Some(To::Free(_)) => {
                    let (point, frame) = (self.point(&x), self.frame(q));
                    (point, Some(Station { frame, rest: UNTURNED, offset: [0.0; 3], blend: 0.125 }))
                }
                None => {
                    let point = self.point(&x);
                    let station = stations.contains(&i).then(|| self.frame(q));
                    let own = |frame| Station { frame, rest: UNTURNED, offset: [0.0; 3], blend: 0.1875 };
                    (point, station.map(own))
                }
            };
            nodes.push(End { point, station });
            ends.push(self.harness.frames);
        }
        let mut before: Option<CarriedFrame> = None;
        for (j, ends) in nodes.windows(2).enumerate() {
            let frame = self.frame(q);
            if let [End { point: a, station: None }, End { point: b, station: None }] = *ends {
                self.harness.segments.push(Segment { a, b, frame, length, stiffness: ea, inversion_stiffness: 50.0 });
            } else {
                let ends = [ends[0], ends[1]];
                let own = StationSegment { ends, frame, length, stiffness: ea, inversion_stiffness: 50.0 };
                self.harness.station_segments.push(own);
            }
            let own = CarriedFrame { frame, rest: UNTURNED };
            let rotated = |station: Station| CarriedFrame { frame: station.frame, rest: station.rest };
            let rest_curvature = [0.2, -0.1, 0.3];
            let mut couple = |a, b, length| {
                self.harness.couplings.push(Coupling { a, b, length, stiffness: c, rest_curvature });
            };
            match ends[0].station.map(rotated) {
                Some(station) => {
                    if let Some(before) = before {
                        couple(before, station, 0.5 * length);
                    }
                    couple(station, own, 0.5 * length);
                }
                None => {
                    if let Some(before) = before {
                        couple(before, own, length);
                    }
                }
            }
            if j + 1 == n
                && let Some(station) = ends[1].station.map(rotated)
            {
                couple(own, station, 0.5 * length);
            }
            before = Some(own);
            self.harness.weights[frame as usize] += length;
            for end in ends {
                let dead = &mut self.harness.dead[end.point as usize];
                dead[2] -= 0.3 * length;
                if let Some(station) = end.station {
                    self.harness.weights[station.frame as usize] += 0.5 * length;
                }
            }
            for (node, end) in [(0, from), (n - 1, to)] {
                if let (true, To::Joint(joint)) = (node == j, end) {
                    self.arms[joint].push(frame);
                }
            }
        }
    }

    /// Couples all pairs of arms of joints that are points.
    pub fn couple_arms(&mut self) {
        for (joint, arms) in self.joints.clone().iter().zip(self.arms.clone()) {
            for (k, &a) in arms.iter().enumerate().filter(|_| joint.hub.is_none()) {
                for &b in &arms[k + 1..] {
                    let (a, b) = (
                        CarriedFrame { frame: a, rest: rotation(&mut self.rng) },
                        CarriedFrame { frame: b, rest: rotation(&mut self.rng) },
                    );
                    let (stiffness, rest_curvature) = ([0.01, 0.008, 0.005], [0.3, 0.1, -0.2]);
                    self.harness.couplings.push(Coupling { a, b, length: 0.03, stiffness, rest_curvature });
                }
            }
        }
    }

    /// A spring with all its features.
    pub fn spring(&mut self, point: u32, frame: Option<u32>) {
        let rng = &mut self.rng;
        let spring = Spring {
            point,
            frame,
            rest: rotation(rng),
            offset: random(rng, 0.05).into(),
            stiffness: 30.0,
            tangent_stiffness: 0.02,
            frame_stiffness: 0.05,
            position: random(rng, 1.0).into(),
            orientation: rotation(rng),
            force: random(rng, 1.0).into(),
        };
        self.harness.springs.push(spring);
    }

    /// Perturbs all points and frames.
    pub fn shake(&mut self, size: f64) {
        for x in &mut self.shape.points {
            *x = (Vector3::from(*x) + random(&mut self.rng, size * 0.02)).into();
        }
        for x in &mut self.shape.compensation {
            *x = random(&mut self.rng, 1e-17).into();
        }
        for q in &mut self.shape.frames {
            let turn = nalgebra::UnitQuaternion::from_scaled_axis(random(&mut self.rng, size));
            *q = (Unit::new_normalize(Quaternion::from(*q)) * turn).coords.into();
        }
    }

    /// Holds a variable at its current value.
    pub fn hold(&mut self, variable: Variable) {
        let target = match variable {
            Variable::Point(i) => {
                let x = self.shape.points[i as usize];
                [x[0], x[1], x[2], 0.0]
            }
            Variable::Frame(c) => self.shape.frames[c as usize],
        };
        let basis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        self.harness.holds.push(Hold { variable, basis, count: 3, target, motion: [0.0; 3] });
    }
}

/// A cable from one end to the other, with a station in the middle.
pub fn cable(seed: u64, n: usize) -> Builder {
    let mut builder = Builder::new(seed);
    builder.branch(n, To::Free([0.0; 3]), To::Free([1.0, 0.2, 0.1]), &[n / 2]);
    builder
}

/// Three branches on a joint.
pub fn fork(seed: u64, n: usize, hub: bool) -> Builder {
    let mut builder = Builder::new(seed);
    let joint = To::Joint(builder.joint([0.5, 0.0, 0.0], hub));
    builder.branch(n, To::Free([0.0; 3]), joint, &[]);
    builder.branch(n, joint, To::Free([0.9, 0.3, 0.0]), &[n / 2]);
    builder.branch(n, joint, To::Free([0.9, -0.3, 0.1]), &[]);
    builder.couple_arms();
    builder
}

/// A loop of two branches between two joints, a point and a hub; with springs.
pub fn ring(seed: u64, n: usize) -> Builder {
    let mut builder = Builder::new(seed);
    let first = To::Joint(builder.joint([0.3, 0.0, 0.0], false));
    let second = To::Joint(builder.joint([0.8, 0.1, 0.0], true));
    builder.branch(n, To::Free([0.0; 3]), first, &[]);
    builder.branch(n, first, second, &[]);
    builder.branch(n, second, first, &[n / 2]);
    builder.branch(n, second, To::Free([1.2, -0.1, 0.2]), &[]);
    builder.couple_arms();
    builder.spring(builder.joints[1].point, builder.joints[1].hub);
    builder.spring(builder.joints[0].point, None);
    builder
}

/// The assembled matrix, both triangles, in elimination order.
pub fn whole(plan: &Plan, memory: &Memory) -> DMatrix<f64> {
    let n = 3 * plan.len();
    let mut whole = DMatrix::zeros(n, n);
    for column in 0..plan.len() as u32 {
        for &row in [column].iter().chain(&plan.elimination.rows[column as usize]) {
            let block = plan.elimination.block(row, column).expect("a block of the pattern") as usize;
            for i in 0..9 {
                let x = memory.blocks[9 * block + i];
                let (r, c) = (3 * row as usize + i % 3, 3 * column as usize + i / 3);
                whole[(r, c)] = x;
                whole[(c, r)] = x;
            }
        }
    }
    whole
}

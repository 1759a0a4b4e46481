//! Description of a harness in f64: made by `gpu` from a problem, and the input of everything else in this crate.
//!
//! Only independent variables exist: points (m) and frames (unit quaternions x, y, z, w). Ends on a hub are not
//! variables: the parts attached to them state how the hub carries them ([`Station`], [`CarriedFrame`]). SI units;
//! rotations along `q ∘ exp(θ)`, θ in the body frame.

/// An independent variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Variable {
    /// Position of a point.
    Point(u32),
    /// Rotation of a frame.
    Frame(u32),
}

/// A segment without stations, `E = ½ ℓ (Γᵀ C Γ + B min(v3, 0)²)`, `v = Rᵀ (x_b − x_a)/ℓ`, `Γ = v −
/// e3`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Its first point.
    pub a: u32,
    /// Its second point.
    pub b: u32,
    /// Its frame.
    pub frame: u32,
    /// ℓ, m.
    pub length: f64,
    /// C: diag(GA1, GA2, EA), N.
    pub stiffness: [f64; 3],
    /// B, N.
    pub inversion_stiffness: f64,
}

/// A station at the end of a segment: the frame `q ∘ rest`, where q is an independent frame. The end of the segment
/// is at `x + R(q) offset`, where x is the end's point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// The independent frame: that of the station, or of the hub that carries it.
    pub frame: u32,
    /// Rest rotation in that frame; the identity for an independent station.
    pub rest: [f64; 4],
    /// Position of the end in that frame, m; zero for an independent station.
    pub offset: [f64; 3],
    /// Weight β of the station's tangent in the segment's.
    pub blend: f64,
}

/// An end of a segment with stations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// The independent point: the node, or the joint that carries it.
    pub point: u32,
    /// The station at this end, if any.
    pub station: Option<Station>,
}

/// A segment with a station at one or both ends: as [`Segment`] with `Γ = v + v × φ − e3`, `φ = Σ 2 β w v` over
/// the stations, `(w, v)` of `q̄ Q`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StationSegment {
    /// Both ends.
    pub ends: [End; 2],
    /// Its frame.
    pub frame: u32,
    /// ℓ, m.
    pub length: f64,
    /// C: diag(GA1, GA2, EA), N.
    pub stiffness: [f64; 3],
    /// B, N.
    pub inversion_stiffness: f64,
}

/// A frame `q ∘ rest` that an independent frame q carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarriedFrame {
    /// The independent frame.
    pub frame: u32,
    /// Rotation in it.
    pub rest: [f64; 4],
}

/// Bending and twist between two frames, within a branch or in a joint:
/// `κ = (2/λ)(1 + |v|²/6) v`, (w ≥ 0, v) of `q̄_a q_b`, `E = ½ λ (κ−κ°)ᵀ C (κ−κ°)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// First frame.
    pub a: CarriedFrame,
    /// Second frame.
    pub b: CarriedFrame,
    /// λ, m.
    pub length: f64,
    /// C: diag(EI1, EI2, GJ), N m².
    pub stiffness: [f64; 3],
    /// κ°, 1/m.
    pub rest_curvature: [f64; 3],
}

/// A spring or a dead force with a lever at one place. With `X = x + R(q) offset` and `S = q ∘ rest`: `E
/// = ½ k |X − X°|² − F·X + k_t (1 − d3(S)·d3(S°)) + ½ k_f |κ|²`, κ that of a [`Coupling`] of length 1 m
/// from S° to S.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The independent point.
    pub point: u32,
    /// The independent frame, if any; without it offset and rest are ignored.
    pub frame: Option<u32>,
    /// Rotation of the place in that frame.
    pub rest: [f64; 4],
    /// Position of the place in that frame, m.
    pub offset: [f64; 3],
    /// k, N/m.
    pub stiffness: f64,
    /// k_t, N m.
    pub tangent_stiffness: f64,
    /// k_f, N m.
    pub frame_stiffness: f64,
    /// X°, m.
    pub position: [f64; 3],
    /// S°.
    pub orientation: [f64; 4],
    /// F, N, world axes.
    pub force: [f64; 3],
}

/// A variable with directions that are, or can be, prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// The variable.
    pub variable: Variable,
    /// Orthonormal directions, world axes for points, body axes for frames; the held ones come first.
    pub basis: [[f64; 3]; 3],
    /// Number of held directions, 0 to 3. Of a frame 0, 2 (third axis held) or 3.
    pub count: u32,
    /// The prescribed value: a position (m; the fourth number is ignored) or a rotation. For a partly held variable the
    /// free components are ignored.
    pub target: [f64; 4],
    /// Prescribed motion of the first step, to first order, m or rad; zero in free directions.
    pub motion: [f64; 3],
}

/// A harness under its conditions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Harness {
    /// Number of points.
    pub points: usize,
    /// Number of frames.
    pub frames: usize,
    /// Segments without stations.
    pub segments: Vec<Segment>,
    /// Segments with stations.
    pub station_segments: Vec<StationSegment>,
    /// Couplings of branches and joints.
    pub couplings: Vec<Coupling>,
    /// Springs, and forces with levers.
    pub springs: Vec<Spring>,
    /// Dead force at each point, N, world axes.
    pub dead: Vec<[f64; 3]>,
    /// Rest length around each frame, m: weight of the shift of its diagonal.
    pub weights: Vec<f64>,
    /// Variables that are, or can be, held; each once.
    pub holds: Vec<Hold>,
}

/// State of a harness.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Positions, m.
    pub points: Vec<[f64; 3]>,
    /// Low-order parts of the positions, m: a position is the unevaluated sum of both parts.
    pub compensation: Vec<[f64; 3]>,
    /// Unit quaternions x, y, z, w.
    pub frames: Vec<[f64; 4]>,
}

/// Scales of forces and moments, and stop criteria.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Scale of forces, N.
    pub force_scale: f64,
    /// Scale of moments, N m.
    pub moment_scale: f64,
    /// The longest branch, m.
    pub length_scale: f64,
    /// Tolerance of the relative residual.
    pub tolerance: f64,
    /// Largest number of iterations.
    pub max_iterations: u32,
    /// The algorithm.
    pub algorithm: Algorithm,
}

/// Algorithm of the minimisation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Algorithm {
    /// Newton's method: a new matrix for every step.
    #[default]
    Newton = 0,
    /// Nonlinear conjugate gradients, preconditioned by a matrix that is refactorised at intervals.
    Gradient = 1,
}

impl Harness {
    /// Whether a hold is still to move.
    pub fn moves(&self) -> bool {
        /// Motion (m or rad) below which a hold is at rest.
        const LEAST: f64 = 1e-14;
        self.holds.iter().any(|hold| hold.motion.iter().any(|x| x.abs() > LEAST))
    }

    /// The topology: equal for all harnesses that one plan serves.
    pub fn topology(&self) -> Topology {
        let station = |end: &End| [end.point, end.station.map_or(NONE, |station| station.frame)];
        Topology {
            points: self.points,
            frames: self.frames,
            segments: self.segments.iter().map(|s| [s.a, s.b, s.frame]).collect(),
            station_segments: self
                .station_segments
                .iter()
                .map(|s| {
                    let ([a, qa], [b, qb]) = (station(&s.ends[0]), station(&s.ends[1]));
                    [a, b, s.frame, qa, qb]
                })
                .collect(),
            couplings: self.couplings.iter().map(|c| [c.a.frame, c.b.frame]).collect(),
            springs: self.springs.iter().map(|s| [s.point, s.frame.unwrap_or(NONE)]).collect(),
            holds: self.holds.iter().map(|hold| hold.variable).collect(),
        }
    }
}

/// No variable.
pub const NONE: u32 = u32::MAX;

/// Variables of every part of a harness; see [`Harness::topology`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Number of points.
    pub points: usize,
    /// Number of frames.
    pub frames: usize,
    /// Two points and a frame.
    pub segments: Vec<[u32; 3]>,
    /// Two points, a frame, and the frames at the two ends or [`NONE`].
    pub station_segments: Vec<[u32; 5]>,
    /// Two frames.
    pub couplings: Vec<[u32; 2]>,
    /// A point, and a frame or [`NONE`].
    pub springs: Vec<[u32; 2]>,
    /// Variables that can be held.
    pub holds: Vec<Variable>,
}

//! A scenario as data: what the hunt generates, transforms and shrinks, and its TOML text.

use std::fmt::Write;
use wireloom::geometry::{Rotation, Vector};

/// A whole scenario. Lists are indexed by each other; names follow from the indices.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Gravity at the beginning, m/s².
    pub gravity: Vector,
    /// Branches.
    pub branches: Vec<Branch>,
    /// Joints: one for every vertex where two or more branches end.
    pub joints: Vec<Joint>,
    /// All constraints, those that begin with a step included.
    pub constraints: Vec<Constraint>,
    /// Loads.
    pub loads: Vec<Load>,
    /// Bodies.
    pub obstacles: Vec<Obstacle>,
    /// Friction of cables on each other, where they may touch.
    pub cables: Option<f64>,
    /// Steps.
    pub steps: Vec<Step>,
    /// Settings of the minimiser; `None`: the defaults.
    pub minimiser: Option<Minimiser>,
}

/// A branch with a section of its own.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Number in the name, which stays when other branches are dropped.
    pub name: usize,
    /// Vertices.
    pub ends: [usize; 2],
    /// Unstressed length, m.
    pub length: f64,
    /// Segments.
    pub segments: usize,
    /// Kind of rod.
    pub rod: &'static str,
    /// Diameter, m.
    pub diameter: f64,
    /// Mass per length, kg/m.
    pub density: f64,
    /// EA, N.
    pub ea: f64,
    /// GA along d1 and d2, N; `None`: the default.
    pub ga: Option<[f64; 2]>,
    /// EI about d1 and d2, N m².
    pub ei: [f64; 2],
    /// GJ, N m².
    pub gj: f64,
    /// Rest curvature about d1 and d2, and rest twist, 1/m.
    pub curvature: Vector,
}

/// A joint.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Vertex.
    pub vertex: usize,
    /// Model.
    pub model: &'static str,
    /// Mass, kg.
    pub mass: f64,
    /// Arms.
    pub arms: Vec<Arm>,
    /// Wires: two arms (indices in `arms`) and the share of the first one's wires.
    pub wires: Vec<(usize, usize, f64)>,
}

/// An arm of a joint.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Name of the branch.
    pub branch: usize,
    /// Frame of the branch (d3 `from → to`) in the joint's frame.
    pub orientation: Rotation,
    /// Offset from the joint, m.
    pub offset: Vector,
    /// Stiffness of its spring about d1, d2 and d3, N m/rad, at the model `compliant-hub`.
    pub spring: Option<[f64; 3]>,
}

/// Place at which something attaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// A vertex: a free end or a joint.
    Vertex(usize),
    /// A branch (by name) at an arc length, m.
    On(usize, f64),
}

/// Orientation of a constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// Nothing is said.
    Open,
    /// d3.
    Tangent(Vector),
    /// The whole frame.
    Frame(Rotation),
}

/// A constraint.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// Number in the name.
    pub name: usize,
    /// `connector`, `collar` or `handle`.
    pub kind: &'static str,
    /// Place at which it attaches.
    pub at: Place,
    /// Held position, m; `None`: where the cable is.
    pub position: Option<Vector>,
    /// Held orientation.
    pub facing: Facing,
    /// Springy handle, N/m.
    pub stiffness: Option<f64>,
    /// The cable runs through, with this friction.
    pub slide: Option<f64>,
    /// The held point moves freely along it.
    pub rail: Option<Vector>,
    /// A hinge about it.
    pub free_axis: Option<Vector>,
    /// Index of the step with which it begins; `None`: from the start.
    pub from_step: Option<usize>,
}

/// A load.
#[derive(Clone, Debug)]
pub struct Load {
    /// Number in the name.
    pub name: usize,
    /// Place at which it acts.
    pub at: Place,
    /// N.
    pub force: Vector,
    /// N m.
    pub moment: Vector,
    /// Factor at the beginning.
    pub factor: f64,
}

/// A body.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Shape, with its size.
    pub shape: Shape,
    /// Position, m.
    pub position: Vector,
    /// Its axes; of a plane the third is the normal.
    pub orientation: Rotation,
    /// Friction.
    pub friction: f64,
}

/// Shape of a body; lengths in m.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Half space below it.
    Plane,
    /// Radius.
    Sphere(f64),
    /// Edges.
    Box(Vector),
    /// Radius and length.
    Cylinder(f64, f64),
}

/// A step.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// Increments.
    pub increments: usize,
    /// Gravity at its end.
    pub gravity: Option<Vector>,
    /// Constraints (by name) that let go.
    pub release: Vec<usize>,
    /// Motions.
    pub moves: Vec<Move>,
    /// Loads (by name) and their factors at its end.
    pub loads: Vec<(usize, f64)>,
}

/// Motion of a constraint.
#[derive(Clone, Debug)]
pub struct Move {
    /// Name of the constraint.
    pub constraint: usize,
    /// Target position, m.
    pub position: Option<Vector>,
    /// Target orientation.
    pub facing: Facing,
    /// Turns about the tangent.
    pub turns: f64,
}

/// Settings of the minimiser.
#[derive(Clone, Copy, Debug)]
pub struct Minimiser {
    /// Kind.
    pub kind: &'static str,
    /// Relative tolerance.
    pub tolerance: f64,
    /// Iterations an increment.
    pub iterations: usize,
}

impl Scene {
    /// The branch of this name.
    ///
    /// # Panics
    /// If there is none.
    pub fn branch(&self, name: usize) -> &Branch {
        self.branches.iter().find(|b| b.name == name).expect("a branch of this name")
    }

    /// The joint at a vertex.
    pub fn joint(&self, vertex: usize) -> Option<&Joint> {
        self.joints.iter().find(|j| j.vertex == vertex)
    }

    /// Length of the longest branch, m.
    pub fn length(&self) -> f64 {
        self.branches.iter().map(|b| b.length).fold(0.0, f64::max)
    }

    /// Gravity at the end of a step, or with `None` at the beginning.
    pub fn gravity_at(&self, step: Option<usize>) -> Vector {
        let upto = step.map_or(0, |k| k + 1).min(self.steps.len());
        self.steps[..upto].iter().filter_map(|s| s.gravity).next_back().unwrap_or(self.gravity)
    }

    /// Factor of a load at the end of a step.
    pub fn factor_at(&self, load: &Load, step: usize) -> f64 {
        let upto = (step + 1).min(self.steps.len());
        let named = self.steps[..upto].iter().flat_map(|s| &s.loads).filter(|(name, _)| *name == load.name);
        named.map(|(_, factor)| *factor).next_back().unwrap_or(load.factor)
    }

    /// Whether anything has friction: the shape then depends on the way.
    pub fn has_friction(&self) -> bool {
        self.obstacles.iter().any(|o| o.friction > 0.0)
            || self.cables.is_some_and(|friction| friction > 0.0)
            || self.constraints.iter().any(|f| f.slide.is_some_and(|friction| friction > 0.0))
    }

    /// The TOML text.
    pub fn text(&self) -> String {
        let mut text = String::from("schema = 1\nname = \"hunted\"\n");
        let _ = writeln!(text, "gravity = {}", list(&self.gravity));
        for branch in &self.branches {
            branch.write(&mut text);
        }
        for joint in &self.joints {
            joint.write(&mut text);
        }
        for constraint in self.constraints.iter().filter(|f| f.from_step.is_none()) {
            text.push_str("[[constraints]]\n");
            self.write_constraint(constraint, &mut text);
        }
        for load in &self.loads {
            let _ = write!(text, "[[loads]]\nname = \"load{}\"\nat = {}\n", load.name, self.place(load.at));
            for (key, value) in [("force", load.force), ("moment", load.moment)] {
                if value != Vector::zeros() {
                    let _ = writeln!(text, "{key} = {}", list(&value));
                }
            }
            if load.factor != 1.0 {
                let _ = writeln!(text, "factor = {:?}", load.factor);
            }
        }
        for (k, obstacle) in self.obstacles.iter().enumerate() {
            obstacle.write(k, &mut text);
        }
        if let Some(friction) = self.cables {
            let _ = write!(text, "[contact]\ncables = true\nfriction = {friction:?}\n");
        }
        if let Some(Minimiser { kind, tolerance, iterations }) = self.minimiser {
            let _ = write!(
                text,
                "[minimiser]\nkind = \"{kind}\"\nforce_tolerance = {tolerance:?}\nmax_iterations = {iterations}\n"
            );
        }
        for (k, step) in self.steps.iter().enumerate() {
            self.write_step(k, step, &mut text);
        }
        text
    }

    fn place(&self, place: Place) -> String {
        match place {
            Place::On(branch, s) => format!("{{ branch = \"b{branch}\", s = {s:?} }}"),
            Place::Vertex(v) if self.joint(v).is_some() => format!("{{ joint = \"V{v}\" }}"),
            Place::Vertex(v) => format!("{{ end = \"V{v}\" }}"),
        }
    }

    fn write_constraint(&self, constraint: &Constraint, text: &mut String) {
        let Constraint { name, kind, at, position, facing, stiffness, slide, rail, free_axis, .. } = constraint;
        let _ = write!(text, "name = \"c{name}\"\nkind = \"{kind}\"\nat = {}\n", self.place(*at));
        if let Some(position) = position {
            let _ = writeln!(text, "position = {}", list(position));
        }
        write_facing(facing, text);
        if let Some(stiffness) = stiffness {
            let _ = writeln!(text, "stiffness = {stiffness:?}");
        }
        if let Some(friction) = slide {
            let _ = write!(text, "slide = true\nfriction = {friction:?}\n");
        }
        if let Some(rail) = rail {
            let _ = writeln!(text, "rail = [{}]", list(rail));
        }
        if let Some(axis) = free_axis {
            let _ = writeln!(text, "free_axis = {}", list(axis));
        }
    }

    fn write_step(&self, k: usize, step: &Step, text: &mut String) {
        let _ = write!(text, "[[steps]]\nname = \"step {k}\"\nincrements = {}\n", step.increments);
        if let Some(gravity) = step.gravity {
            let _ = writeln!(text, "gravity = {}", list(&gravity));
        }
        if !step.release.is_empty() {
            let names: Vec<String> = step.release.iter().map(|name| format!("c{name}")).collect();
            let _ = writeln!(text, "release = {names:?}");
        }
        for constraint in self.constraints.iter().filter(|f| f.from_step == Some(k)) {
            text.push_str("[[steps.add]]\n");
            self.write_constraint(constraint, text);
        }
        for Move { constraint, position, facing, turns } in &step.moves {
            let _ = write!(text, "[[steps.move]]\nconstraint = \"c{constraint}\"\n");
            if let Some(position) = position {
                let _ = writeln!(text, "position = {}", list(position));
            }
            write_facing(facing, text);
            if *turns != 0.0 {
                let _ = writeln!(text, "turns = {turns:?}");
            }
        }
        for (load, factor) in &step.loads {
            let _ = write!(text, "[[steps.load]]\nload = \"load{load}\"\nfactor = {factor:?}\n");
        }
        let nothing = step.gravity.is_none()
            && step.release.is_empty()
            && step.moves.is_empty()
            && step.loads.is_empty()
            && !self.constraints.iter().any(|f| f.from_step == Some(k));
        if nothing {
            text.push_str("wait = true\n");
        }
    }
}

impl Branch {
    fn write(&self, text: &mut String) {
        let Branch { name, ends: [from, to], length, segments, rod, diameter, density, ea, ga, ei, gj, curvature } =
            self;
        let _ = write!(
            text,
            "[sections.s{name}]\ndiameter = {diameter:?}\nlinear_density = {density:?}\naxial_stiffness = {ea:?}\n\
             bending_stiffness = {ei:?}\ntorsion_stiffness = {gj:?}\n"
        );
        if let Some(ga) = ga {
            let _ = writeln!(text, "shear_stiffness = {ga:?}");
        }
        let _ = write!(
            text,
            "[[branches]]\nname = \"b{name}\"\nfrom = \"V{from}\"\nto = \"V{to}\"\nsection = \"s{name}\"\n\
             length = {length:?}\n\
             segments = {segments}\nrod = \"{rod}\"\n"
        );
        if *curvature != Vector::zeros() {
            let _ = writeln!(text, "curvature = {}", list(curvature));
        }
    }
}

impl Joint {
    fn write(&self, text: &mut String) {
        let Joint { vertex, model, mass, arms, wires } = self;
        let _ = write!(text, "[[joints]]\nname = \"V{vertex}\"\nmodel = \"{model}\"\n");
        if *mass > 0.0 {
            let _ = writeln!(text, "mass = {mass:?}");
        }
        text.push_str("arms = [\n");
        for Arm { branch, orientation, offset, spring } in arms {
            let _ = write!(text, "  {{ branch = \"b{branch}\", orientation = {}", quaternion(orientation));
            if *offset != Vector::zeros() {
                let _ = write!(text, ", offset = {}", list(offset));
            }
            if let Some([k1, k2, k3]) = spring {
                let _ = write!(text, ", bending_stiffness = [{k1:?}, {k2:?}], torsion_stiffness = {k3:?}");
            }
            text.push_str(" },\n");
        }
        text.push_str("]\n");
        if !wires.is_empty() {
            text.push_str("wires = [\n");
            for (a, b, share) in wires {
                let [a, b] = [a, b].map(|arm| arms[*arm].branch);
                let _ = writeln!(text, "  {{ between = [\"b{a}\", \"b{b}\"], share = {share:?} }},");
            }
            text.push_str("]\n");
        }
    }
}

impl Obstacle {
    fn write(&self, k: usize, text: &mut String) {
        let Obstacle { shape, position, orientation, friction } = self;
        let _ = write!(text, "[[obstacles]]\nname = \"o{k}\"\n");
        let _ = match shape {
            Shape::Plane => {
                let normal = orientation * Vector::z();
                write!(text, "shape = \"plane\"\npoint = {}\nnormal = {}\n", list(position), list(&normal))
            }
            Shape::Sphere(radius) => write!(text, "shape = \"sphere\"\nradius = {radius:?}\n"),
            Shape::Box(size) => write!(text, "shape = \"box\"\nsize = {}\n", list(size)),
            Shape::Cylinder(radius, length) => {
                write!(text, "shape = \"cylinder\"\nradius = {radius:?}\nlength = {length:?}\n")
            }
        };
        if !matches!(shape, Shape::Plane) {
            let _ = write!(text, "position = {}\norientation = {}\n", list(position), quaternion(orientation));
        }
        if *friction > 0.0 {
            let _ = writeln!(text, "friction = {friction:?}");
        }
    }
}

fn write_facing(facing: &Facing, text: &mut String) {
    let _ = match facing {
        Facing::Open => Ok(()),
        Facing::Tangent(tangent) => writeln!(text, "tangent = {}", list(tangent)),
        Facing::Frame(frame) => writeln!(text, "orientation = {}", quaternion(frame)),
    };
}

fn list(v: &Vector) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

fn quaternion(q: &Rotation) -> String {
    format!("[{:?}, {:?}, {:?}, {:?}]", q.w, q.i, q.j, q.k)
}

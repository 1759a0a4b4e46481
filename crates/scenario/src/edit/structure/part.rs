//! Kinds of parts that have names.

/// A kind of parts that have names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A branch.
    Branch,
    /// A vertex: an end or a joint.
    Vertex,
    /// A section.
    Section,
    /// A constraint, whether it acts from the start or begins with a step.
    Constraint,
    /// An obstacle.
    Obstacle,
    /// A requirement.
    Requirement,
    /// A load.
    Load,
    /// A step.
    Step,
}

impl Part {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Part::Branch => "branch",
            Part::Vertex => "vertex",
            Part::Section => "section",
            Part::Constraint => "constraint",
            Part::Obstacle => "obstacle",
            Part::Requirement => "requirement",
            Part::Load => "load",
            Part::Step => "step",
        }
    }

    /// The list of its entries at the top level of a scenario.
    pub(super) fn list(self) -> &'static str {
        match self {
            Part::Branch => "branches",
            Part::Vertex => "joints",
            Part::Section => "sections",
            Part::Constraint => "constraints",
            Part::Obstacle => "obstacles",
            Part::Requirement => "requirements",
            Part::Load => "loads",
            Part::Step => "steps",
        }
    }
}

/// Tables of the step operations that begin a constraint.
pub(super) const BEGINNINGS: [&str; 4] = ["add", "grasp", "clip", "mate"];

//! Handles of equilibria. Arrays are views of the result's memory.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, OnceLock};
use wireloom::geometry::{Vector, columns};
use wireloom::result::{BranchResult, ConstraintResult, SectionResult};
use wireloom::{Run, StepResult, result};

/// Where the result of an increment is kept.
#[derive(Clone)]
enum Kept {
    /// In a run, at an index.
    InRun(Arc<Run>, usize),
    /// By itself.
    Alone(Arc<StepResult>),
}

impl Kept {
    fn get(&self) -> &StepResult {
        match self {
            Kept::InRun(run, step) => &run.steps[*step],
            Kept::Alone(step) => step,
        }
    }
}

/// The equilibrium at the end of an increment.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Step(Kept);

impl Step {
    pub fn of_run(run: &Arc<Run>, index: usize) -> Self {
        Self(Kept::InRun(run.clone(), index))
    }

    pub fn alone(step: StepResult) -> Self {
        Self(Kept::Alone(Arc::new(step)))
    }
}

/// Names of joints of a mechanism, each with the values of its freedoms, rad and m.
type JointValues = Vec<(String, Vec<f64>)>;

/// Branch of an arm, its set (rad), and the energy dissipated there in the increment and since the start, J.
type ArmFriction = (String, [f64; 3], (f64, f64));

/// Name, position (m), orientation `[w, x, y, z]`, and what slips at its arms.
type Joint = (String, [f64; 3], [f64; 4], Vec<ArmFriction>);

/// The word of a cause, and its sentence.
type Cause = (&'static str, String);

#[pymethods]
impl Step {
    #[getter]
    fn name(&self) -> &str {
        &self.0.get().name
    }

    #[getter]
    fn increment(&self) -> usize {
        self.0.get().increment
    }

    #[getter]
    fn increments(&self) -> usize {
        self.0.get().increments
    }

    #[getter]
    fn status(&self) -> &'static str {
        self.0.get().status.word()
    }

    #[getter]
    fn stable(&self) -> Option<bool> {
        self.0.get().stable
    }

    /// Energy by effect, J, and `total`.
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let energy = self.0.get().energy;
        let parts = [
            ("total", energy.total()),
            ("stretch", energy.stretch),
            ("shear", energy.shear),
            ("bend", energy.bend),
            ("twist", energy.twist),
            ("gravity", energy.gravity),
            ("load", energy.load),
            ("joint", energy.joint),
            ("constraint", energy.constraint),
        ];
        let dict = PyDict::new(py);
        parts.into_iter().try_for_each(|(name, value)| dict.set_item(name, value))?;
        Ok(dict)
    }

    /// Branch, arc length (m), bend radius (m) and its limit (m) of the tightest bend.
    fn tightest_bend(&self) -> Option<(String, f64, f64, Option<f64>)> {
        let bend = self.0.get().min_bend_radius.as_ref()?;
        Some((bend.branch.clone(), bend.s, bend.value, bend.limit))
    }

    /// Kind, iterations, factorisations, seconds and force residual.
    fn minimiser(&self) -> (String, usize, usize, f64, f64) {
        let own = &self.0.get().minimiser;
        (own.kind.clone(), own.iterations, own.factorisations, own.seconds, own.force_residual)
    }

    /// Branches with their names, in the order of the scenario.
    fn branches(&self) -> Vec<(String, Branch)> {
        let of = |(index, branch): (usize, &BranchResult)| {
            (branch.name.clone(), Branch { step: self.0.clone(), index, directors: OnceLock::new() })
        };
        self.0.get().branches.iter().enumerate().map(of).collect()
    }

    /// Constraints that act, with their names.
    fn constraints(&self) -> Vec<(String, Constraint)> {
        let of =
            |(index, own): (usize, &ConstraintResult)| (own.name.clone(), Constraint { step: self.0.clone(), index });
        self.0.get().constraints.iter().enumerate().map(of).collect()
    }

    /// Names, positions (m) and orientations `[w, x, y, z]` of the joints, and what slips at their arms.
    fn joints(&self) -> Vec<Joint> {
        let of_arm =
            |own: &result::ArmFriction| (own.branch.clone(), own.set.into(), (own.dissipated, own.dissipated_in_all));
        let of = |joint: &result::JointResult| {
            let friction = joint.friction.iter().map(of_arm).collect();
            (joint.name.clone(), joint.position.into(), quaternion(&joint.orientation), friction)
        };
        self.0.get().joints.iter().map(of).collect()
    }

    /// Names of the mechanisms, with the names and values (rad, m) of their joints.
    fn mechanisms(&self) -> Vec<(String, JointValues)> {
        self.0.get().mechanisms.iter().map(|own| (own.name.clone(), own.joints.clone())).collect()
    }

    /// Names and positions (m) of the markers.
    fn markers(&self) -> Vec<(String, [f64; 3])> {
        self.0.get().markers.iter().map(|marker| (marker.name.clone(), marker.position.into())).collect()
    }
}

fn quaternion(rotation: &wireloom::geometry::Rotation) -> [f64; 4] {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k]
}

/// A branch of an equilibrium.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Branch {
    step: Kept,
    index: usize,
    /// d1, d2 and d3 at every node, once they are asked for: results keep quaternions.
    directors: OnceLock<Arc<[Vec<Vector>; 3]>>,
}

impl Branch {
    fn get(&self) -> &BranchResult {
        &self.step.get().branches[self.index]
    }
}

#[pymethods]
impl Branch {
    #[getter]
    fn diameter(&self) -> f64 {
        self.get().diameter
    }

    #[getter]
    fn bend_radius_limit(&self) -> Option<f64> {
        self.get().bend_radius_limit
    }

    #[getter]
    fn axial_stiffness(&self) -> f64 {
        self.get().axial_stiffness
    }

    /// At each node, m.
    #[getter]
    fn diameters(&self) -> Vec<f64> {
        let own = self.get();
        (0..own.s.len()).map(|node| own.diameter_at(node)).collect()
    }

    /// At each node, m; NaN where there is none.
    #[getter]
    fn bend_radius_limits(&self) -> Vec<f64> {
        let own = self.get();
        (0..own.s.len()).map(|node| own.bend_radius_limit_at(node).unwrap_or(f64::NAN)).collect()
    }

    /// Name, both arc lengths, diameter, limit of the bend radius and EA of each part with a section of its own.
    #[getter]
    fn sections(&self) -> Vec<(String, f64, f64, f64, Option<f64>, f64)> {
        let parts = self.get().sections.iter();
        let part = |own: &SectionResult| {
            (own.section.clone(), own.from, own.to, own.diameter, own.bend_radius_limit, own.axial_stiffness)
        };
        parts.map(part).collect()
    }

    #[getter]
    fn twist_turns(&self) -> f64 {
        self.get().twist_turns
    }

    /// Estimated discretisation errors: position (m), force (N), moment (N m), least bend radius (m).
    fn error(&self) -> Option<(f64, f64, f64, Option<f64>)> {
        let error = self.get().error?;
        Some((error.position, error.force, error.moment, error.bend_radius))
    }

    /// Order of the scheme in the length of segments, all along the branch.
    fn order(&self) -> Option<u32> {
        self.get().error.map(|error| error.order)
    }

    /// Deviation from the drawn line: median, largest (m), its arc length (m), the word of its cause and the sentence.
    fn deviation(&self) -> Option<(f64, f64, f64, Option<Cause>)> {
        let own = self.get().deviation.as_ref()?;
        Some((own.median, own.max, own.s, own.cause.as_ref().map(|cause| (cause.word(), cause.to_string()))))
    }

    /// Energy dissipated by the friction within its section, J: in the increment, and since the start.
    fn dissipated(&self) -> Option<(f64, f64)> {
        self.get().friction.as_ref().map(|friction| (friction.dissipated, friction.dissipated_in_all))
    }

    /// Set at every node; `None` for an elastic section.
    fn set(&self) -> Option<Field> {
        self.get().friction.as_ref().map(|_| Field::of(self, Quantity::Set))
    }

    fn s(&self) -> Field {
        Field::of(self, Quantity::ArcLength)
    }

    fn position(&self) -> Field {
        Field::of(self, Quantity::Position)
    }

    fn force(&self) -> Field {
        Field::of(self, Quantity::Force)
    }

    fn moment(&self) -> Field {
        Field::of(self, Quantity::Moment)
    }

    fn bend_radius(&self) -> Field {
        Field::of(self, Quantity::BendRadius)
    }

    /// The director d1, d2 or d3 (`k` = 0, 1, 2) at every node; `None` for another `k`.
    fn director(&self, k: usize) -> Option<Field> {
        let all = self.directors.get_or_init(|| {
            let mut all = [const { Vec::new() }; 3];
            for own in self.get().frame.iter().map(columns) {
                all.iter_mut().zip(own).for_each(|(list, d)| list.push(d));
            }
            Arc::new(all)
        });
        (k < 3).then(|| Field(Memory::Directors(all.clone(), k)))
    }
}

/// A constraint of an equilibrium.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Constraint {
    step: Kept,
    index: usize,
}

impl Constraint {
    fn get(&self) -> &ConstraintResult {
        &self.step.get().constraints[self.index]
    }
}

#[pymethods]
impl Constraint {
    #[getter]
    fn kind(&self) -> &str {
        &self.get().kind
    }

    #[getter]
    fn position(&self) -> [f64; 3] {
        self.get().position.into()
    }

    #[getter]
    fn orientation(&self) -> [f64; 4] {
        quaternion(&self.get().orientation)
    }

    #[getter]
    fn force(&self) -> [f64; 3] {
        self.get().force.into()
    }

    #[getter]
    fn moment(&self) -> [f64; 3] {
        self.get().moment.into()
    }

    /// Names and values of the outputs of its kind, SI.
    #[getter]
    fn outputs(&self) -> Vec<(String, f64)> {
        self.get().outputs.clone()
    }
}

/// Quantities of nodes that are stored as they are shown.
#[derive(Clone, Copy)]
enum Quantity {
    ArcLength,
    Position,
    Force,
    Moment,
    BendRadius,
    Set,
}

enum Memory {
    OfBranch(Kept, usize, Quantity),
    Directors(Arc<[Vec<Vector>; 3]>, usize),
}

/// Values at the nodes of a branch. It keeps their memory alive; NumPy makes a read-only view of it.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Field(Memory);

impl Field {
    fn of(branch: &Branch, quantity: Quantity) -> Self {
        Self(Memory::OfBranch(branch.step.clone(), branch.index, quantity))
    }
}

/// Address and number of the values of a list of vectors, three for each.
fn vectors(list: &[Vector]) -> (usize, Vec<usize>) {
    // Vectors are three numbers side by side.
    const { assert!(size_of::<Vector>() == 3 * size_of::<f64>() && align_of::<Vector>() == align_of::<f64>()) };
    (list.as_ptr() as usize, vec![list.len(), 3])
}

fn numbers(list: &[f64]) -> (usize, Vec<usize>) {
    (list.as_ptr() as usize, vec![list.len()])
}

#[pymethods]
impl Field {
    /// The array interface of NumPy, version 3.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (address, shape) = match &self.0 {
            Memory::Directors(all, k) => vectors(&all[*k]),
            Memory::OfBranch(step, index, quantity) => {
                let branch = &step.get().branches[*index];
                match quantity {
                    Quantity::ArcLength => numbers(&branch.s),
                    Quantity::Position => vectors(&branch.position),
                    Quantity::Force => vectors(&branch.force),
                    Quantity::Moment => vectors(&branch.moment),
                    Quantity::BendRadius => numbers(&branch.bend_radius),
                    Quantity::Set => vectors(branch.friction.as_ref().map_or(&[], |friction| &friction.set)),
                }
            }
        };
        let dict = PyDict::new(py);
        dict.set_item("version", 3)?;
        dict.set_item("typestr", if cfg!(target_endian = "little") { "<f8" } else { ">f8" })?;
        dict.set_item("shape", pyo3::types::PyTuple::new(py, shape)?)?;
        // Read-only.
        dict.set_item("data", (address, true))?;
        Ok(dict)
    }
}

//! VTK files for ParaView: a step as `.vtp` (PolyData, one polyline for each branch), and a `.pvd` that makes a time
//! series of many.

use crate::format::{Ended, File, Format, Increment, Surroundings};
use crate::local::{Local, node_count};
use crate::sheet;
use crate::xml::escape;
use std::io::{self, BufWriter, Write};
use wireloom_core::Vector;
use wireloom_core::equilibrium::{ArmFriction, BranchResult, Run, StepResult};
use wireloom_core::identity::{Identified, Identities};
use wireloom_core::obstacle::Surface;
use wireloom_core::requirement::Violation;

/// Writes `step` as VTK PolyData XML with appended raw data (little endian, 64-bit headers).
///
/// The field data has the `status` of the increment and the `violations` of requirements at its end, a sentence each;
/// the verdict on the whole run is in `result.json`. The array `set d1 d2 d3 [1/m]` is there where a section slips or
/// yields, `set at joint d1 d2 d3 [rad]` where an arm slips on its hub: at the node at the joint. Branches with fewer
/// than two nodes are omitted; the cell arrays `branch` and `name` hold the index of the branch in the scenario and its
/// name, and `part` its part number, where any branch has one. Point arrays carry their units in their names; `bend
/// limit/radius` is NaN where a branch has no limit.
///
/// # Errors
/// Those of `out`; `InvalidInput` where a branch's vectors differ in length.
pub fn write(step: &StepResult, identities: &Identities, out: &mut impl Write) -> io::Result<()> {
    let mut data = Data { field: field(step), ..Data::default() };
    let friction = step.branches.iter().any(|branch| branch.friction.is_some());
    let arms: Vec<&ArmFriction> = step.joints.iter().flat_map(|joint| &joint.friction).collect();
    for (index, branch) in step.branches.iter().enumerate() {
        let n = node_count(branch)?;
        if n >= 2 {
            data.push(index as i64, branch, n);
            let identity = identities.find(Identified::Branch, &branch.name);
            data.parts.push(identity.and_then(|identity| identity.part.clone()).unwrap_or_default());
            if friction {
                let set = |i| branch.friction.as_ref().map_or_else(Vector::zeros, |friction| friction.set[i]);
                data.set.extend((0..n).flat_map(|i| <[f64; 3]>::from(set(i))));
            }
            if !arms.is_empty() {
                let at = |i: usize, arm: &&&ArmFriction| {
                    arm.branch == branch.name && i == if arm.starts_here { 0 } else { n - 1 }
                };
                let set = |i| arms.iter().find(|arm| at(i, arm)).map_or_else(Vector::zeros, |arm| arm.set);
                data.set_at_joint.extend((0..n).flat_map(|i| <[f64; 3]>::from(set(i))));
            }
        }
    }
    data.write(&mut BufWriter::new(out))
}

/// Writes surfaces of obstacles as VTK PolyData XML, in the same form: `surfaces` in the world's axes, m; the cell
/// array `obstacle` holds the index of each.
///
/// # Errors
/// Those of `out`.
pub fn write_surfaces(surfaces: &[(usize, Surface)], out: &mut impl Write) -> io::Result<()> {
    let (mut points, mut connectivity, mut offsets, mut obstacle) = (vec![], vec![], vec![], vec![]);
    for (index, Surface { corners, triangles }) in surfaces {
        let first = (points.len() / 3) as i64;
        points.extend(corners.iter().flat_map(|corner| corner.iter().copied()));
        for triangle in triangles {
            connectivity.extend(triangle.map(|k| first + i64::from(k)));
            offsets.push(connectivity.len() as i64);
            obstacle.push(*index as i64);
        }
    }
    let mut appended = Appended::default();
    let out = &mut BufWriter::new(out);
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <PolyData>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"{}\">\n\
         <CellData>",
        points.len() / 3,
        offsets.len()
    )?;
    out.write_all(appended.integers("obstacle", &obstacle).as_bytes())?;
    writeln!(out, "</CellData>\n<Points>")?;
    out.write_all(appended.floats("Points", 3, &points).as_bytes())?;
    writeln!(out, "</Points>\n<Polys>")?;
    out.write_all(appended.integers("connectivity", &connectivity).as_bytes())?;
    out.write_all(appended.integers("offsets", &offsets).as_bytes())?;
    write!(out, "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_")?;
    out.write_all(&appended.bytes)?;
    writeln!(out, "\n</AppendedData>\n</VTKFile>")?;
    out.flush()
}

/// One file of a series.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesFile {
    /// Path of the `.vtp`, relative to the `.pvd`.
    pub file: String,
    /// Time, in steps: see [`times`].
    pub time: f64,
}

/// The time of every entry of `run.steps`, in steps: `k + increment/increments` within step `k = 0, 1, …`, so
/// that the first step ends at 1.
pub fn times(run: &Run) -> Vec<f64> {
    let mut k = 0.0;
    let mut times = Vec::with_capacity(run.steps.len());
    for (i, step) in run.steps.iter().enumerate() {
        if let Some(previous) = i.checked_sub(1).map(|i| &run.steps[i])
            && (previous.name != step.name || previous.increment >= step.increment)
        {
            k += 1.0;
        }
        let fraction = if step.increments == 0 { 1.0 } else { step.increment as f64 / step.increments as f64 };
        times.push(k + fraction);
    }
    times
}

/// Writes a `.pvd` over `files`, in the order given; consecutive files of the same time are its parts.
///
/// # Errors
/// Those of `out`.
pub fn write_series(files: &[SeriesFile], out: &mut impl Write) -> io::Result<()> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
         <Collection>\n",
    );
    let mut part = 0;
    for (k, SeriesFile { file, time }) in files.iter().enumerate() {
        part = if k > 0 && files[k - 1].time == *time { part + 1 } else { 0 };
        text += &format!("<DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" file=\"{}\"/>\n", escape(file));
    }
    text += "</Collection>\n</VTKFile>\n";
    out.write_all(text.as_bytes())
}

/// The arrays of a file, in the order in which they are appended.
#[derive(Default)]
struct Data {
    /// The field data, as elements.
    field: String,
    points: Vec<f64>,
    scalars: [Vec<f64>; SCALARS.len()],
    vectors: [Vec<f64>; VECTORS.len()],
    /// Set, 1/m; empty where no branch has friction.
    set: Vec<f64>,
    /// Set of arms, rad; empty where no arm slips.
    set_at_joint: Vec<f64>,
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    branch: Vec<i64>,
    names: Vec<String>,
    /// Part numbers; empty words where there is none.
    parts: Vec<String>,
}

/// Status and violations of an increment as field data.
fn field(step: &StepResult) -> String {
    let sentence = |violation: &Violation| {
        let Violation { name, measure, severity, value, limit, bound, place } = violation;
        let (quantity, severity, bound) = (measure.word(), severity.word(), bound.word());
        let [value, limit] = [*value, *limit].map(|number| sheet::value(*measure, number));
        let words = format!("{name} ({severity}): {quantity} {value}, {bound} {limit}");
        match place.to_string() {
            place if place.is_empty() => words,
            place => format!("{words}, {place}"),
        }
    };
    let violations: Vec<String> = step.violations.iter().map(sentence).collect();
    strings("status", &[step.status.word().to_owned()]) + &strings("violations", &violations)
}

/// An array of strings, each as the codes of its bytes with a zero behind.
fn strings(name: &str, all: &[String]) -> String {
    let codes: String = all.iter().flat_map(|text| text.bytes().chain([0])).map(|byte| format!("{byte} ")).collect();
    let count = all.len();
    format!("<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"{count}\" format=\"ascii\">\n{codes}\n</Array>\n")
}

const SCALARS: [&str; 8] = [
    "arc length [m]",
    "tube radius [m]",
    "curvature [1/m]",
    "bend limit/radius",
    "tension [N]",
    "shear force [N]",
    "bending moment [N m]",
    "torque [N m]",
];

/// Set about d1, d2 and d3, of branches with friction within their section; 0 of the others.
const SET: &str = "set d1 d2 d3 [1/m]";

/// Set of an arm that slips on its hub about d1, d2 and d3, at the end of its branch; 0 of the others.
const SET_AT_JOINT: &str = "set at joint d1 d2 d3 [rad]";

const VECTORS: [&str; 4] = ["force [N]", "moment [N m]", "d1", "d3"];

impl Data {
    fn push(&mut self, index: i64, branch: &BranchResult, nodes: usize) {
        let first = (self.points.len() / 3) as i64;
        for i in 0..nodes {
            let local = Local::at(branch, i);
            let limit = branch.bend_radius_limit_at(i).unwrap_or(f64::NAN);
            self.points.extend(branch.position[i].iter());
            let scalars = [
                branch.s[i],
                0.5 * branch.diameter_at(i),
                local.curvature,
                limit * local.curvature,
                local.tension,
                local.shear,
                local.bending_moment,
                local.torque,
            ];
            self.scalars.iter_mut().zip(scalars).for_each(|(array, value)| array.push(value));
            let vectors = [branch.force[i], branch.moment[i], local.d1, local.d3];
            self.vectors.iter_mut().zip(vectors).for_each(|(array, value)| array.extend(value.iter()));
        }
        let end = first + nodes as i64;
        self.connectivity.extend(first..end);
        self.offsets.push(end);
        self.branch.push(index);
        self.names.push(branch.name.clone());
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut appended = Appended::default();
        let (points, lines) = (self.points.len() / 3, self.offsets.len());
        writeln!(
            out,
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <PolyData>\n\
             <FieldData>\n{}</FieldData>\n\
             <Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"0\" NumberOfLines=\"{lines}\" \
             NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n\
             <PointData>",
            self.field
        )?;
        for (name, array) in SCALARS.iter().zip(&self.scalars) {
            out.write_all(appended.floats(name, 1, array).as_bytes())?;
        }
        for (name, array) in VECTORS.iter().zip(&self.vectors) {
            out.write_all(appended.floats(name, 3, array).as_bytes())?;
        }
        for (name, array) in [(SET, &self.set), (SET_AT_JOINT, &self.set_at_joint)] {
            if !array.is_empty() {
                out.write_all(appended.floats(name, 3, array).as_bytes())?;
            }
        }
        writeln!(out, "</PointData>\n<CellData>")?;
        out.write_all(appended.integers("branch", &self.branch).as_bytes())?;
        out.write_all(strings("name", &self.names).as_bytes())?;
        if self.parts.iter().any(|part| !part.is_empty()) {
            out.write_all(strings("part", &self.parts).as_bytes())?;
        }
        writeln!(out, "</CellData>\n<Points>")?;
        out.write_all(appended.floats("Points", 3, &self.points).as_bytes())?;
        writeln!(out, "</Points>\n<Lines>")?;
        out.write_all(appended.integers("connectivity", &self.connectivity).as_bytes())?;
        out.write_all(appended.integers("offsets", &self.offsets).as_bytes())?;
        write!(out, "</Lines>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_")?;
        out.write_all(&appended.bytes)?;
        writeln!(out, "\n</AppendedData>\n</VTKFile>")?;
        out.flush()
    }
}

/// The appended block: each array is its length in bytes (u64), then its numbers.
#[derive(Default)]
struct Appended {
    bytes: Vec<u8>,
}

impl Appended {
    fn floats(&mut self, name: &str, components: usize, values: &[f64]) -> String {
        self.array("Float64", name, components, values.len(), values.iter().map(|v| v.to_le_bytes()))
    }

    fn integers(&mut self, name: &str, values: &[i64]) -> String {
        self.array("Int64", name, 1, values.len(), values.iter().map(|v| v.to_le_bytes()))
    }

    /// Appends the numbers and returns the element that points to them.
    fn array(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        count: usize,
        numbers: impl Iterator<Item = [u8; 8]>,
    ) -> String {
        let offset = self.bytes.len();
        self.bytes.extend((8 * count as u64).to_le_bytes());
        self.bytes.extend(numbers.flatten());
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }
}

/// The format `vtk`: files of increments, and a series of them.
pub struct Vtk;

/// Obstacles that stand still, where increments are written one by one.
const STANDING: &str = "vtk/obstacles.vtp";
/// Harness and obstacles that a session offers.
const HARNESS: &str = "harness.vtp";
const OBSTACLES: &str = "obstacles.vtp";

impl Format for Vtk {
    fn key(&self) -> Option<&'static str> {
        Some("vtk")
    }

    fn files(&self) -> &'static [&'static str] {
        &["vtk/NNNN.vtp", "harness.pvd", STANDING, "vtk/obstacles-NNNN.vtp"]
    }

    fn media_type(&self) -> &'static str {
        "application/octet-stream"
    }

    fn bytes_per_node(&self) -> usize {
        150
    }

    fn at_increment<'a>(&self, ended: &'a Increment<'a>) -> Vec<File<'a>> {
        let Increment { number, end, surroundings, identities } = *ended;
        let harness = File::new(harness_file(number), |mut out| write(end, identities, &mut out));
        let bodies = |name: String, moving: bool| {
            File::new(name, move |mut out| write_surfaces(&surroundings.surfaces(end, moving), &mut out))
        };
        let mut files = vec![harness];
        files.extend(surroundings.any(true).then(|| bodies(moving_file(number), true)));
        files.extend((number == 1 && surroundings.any(false)).then(|| bodies(STANDING.to_owned(), false)));
        files
    }

    fn increment_names(&self, number: usize, surroundings: &Surroundings) -> Vec<String> {
        let mut names = vec![harness_file(number)];
        names.extend(surroundings.any(true).then(|| moving_file(number)));
        names.extend((number == 1 && surroundings.any(false)).then(|| STANDING.to_owned()));
        names
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        vec![File::new("harness.pvd", |mut out| write_series(&series(ended), &mut out))]
    }

    fn offered(&self, _: &[&str], obstacles: bool) -> Vec<String> {
        let all = [Some(HARNESS), obstacles.then_some(OBSTACLES)];
        all.into_iter().flatten().map(str::to_owned).collect()
    }

    fn at_hand<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        let Some(end) = ended.run.steps.last() else { return vec![] };
        let harness = File::new(HARNESS, |mut out| write(end, &ended.run.identities, &mut out));
        let bodies = |mut out: &mut dyn Write| write_surfaces(&ended.surroundings.all_surfaces(end), &mut out);
        let some = !ended.surroundings.obstacles().is_empty();
        [Some(harness), some.then(|| File::new(OBSTACLES, bodies))].into_iter().flatten().collect()
    }
}

/// The harness at an increment.
fn harness_file(number: usize) -> String {
    format!("vtk/{number:04}.vtp")
}

/// Obstacles that move, at an increment.
fn moving_file(number: usize) -> String {
    format!("vtk/obstacles-{number:04}.vtp")
}

/// All increments, each with the obstacles at its time.
fn series(ended: &Ended<'_>) -> Vec<SeriesFile> {
    let mut all = vec![];
    for (k, &time) in ended.times.iter().enumerate() {
        let file = |file: String| SeriesFile { file, time };
        all.push(file(harness_file(k + 1)));
        all.extend(ended.surroundings.any(false).then(|| file(STANDING.to_owned())));
        all.extend(ended.surroundings.any(true).then(|| file(moving_file(k + 1))));
    }
    all
}

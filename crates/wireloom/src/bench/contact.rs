//! Cost of contact: a large harness lies on a body of many triangles while gravity tilts; the same harness without the
//! body for comparison.

use std::fmt::Write;
use wireloom_core::{Registry, Status};
use wireloom_scenario::Files;
use wireloom_solve::Control;

/// Joints along the trunk, each with an arm to either side; those of every other one are plugged in, the rest hang
/// free.
const JOINTS: usize = 20;
/// Length of the trunk between joints, and of an arm; longest segment; all in m.
const PITCH: f64 = 0.1;
const ARM: f64 = 0.2;
const SPACING: f64 = 0.0025;
/// Increments in which gravity tilts.
const INCREMENTS: usize = 10;
/// Squares along each edge of the body, each of two triangles.
const DIVISIONS: usize = 92;

/// Harness that sags onto a body.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactCost {
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Joints.
    pub joints: usize,
    /// Triangles of the body.
    pub triangles: usize,
    /// With the body.
    pub touching: Tilting,
    /// Without it.
    pub alone: Tilting,
}

/// The increments in which gravity tilts.
#[derive(Clone, Debug, PartialEq)]
pub struct Tilting {
    /// Increments.
    pub increments: usize,
    /// Increments that did not converge, that of sagging among them.
    pub failures: usize,
    /// Iterations in them.
    pub iterations: usize,
    /// Time spent in them, s.
    pub seconds: f64,
    /// Places of the cables that the body pushes in the end.
    pub contacts: usize,
}

impl ContactCost {
    /// Time of an increment with the body relative to one without.
    pub fn ratio(&self) -> f64 {
        self.touching.seconds / self.alone.seconds
    }
}

/// A harness that lies flat without weight, sags onto a body, which is not counted, and lies there while gravity tilts.
///
/// # Panics
/// Never: it makes its own scenario.
pub fn contact(registry: &Registry) -> ContactCost {
    let body = Body::new();
    let [touching, alone] = [OBSTACLE, ""].map(|obstacle| {
        let (_, built) = crate::load_with_files(&text(obstacle), &body, registry).map_err(|_| "it is sound").unwrap();
        let counts = (built.network.branches.iter().map(|b| b.rod.mesh().nodes()).sum(), built.network.joints.len());
        let mut failures = 0;
        let run = crate::run(built, &mut |_, end| {
            failures += usize::from(end.status != Status::Converged);
            Control::Continue
        });
        let end = run.steps.last();
        let of_work =
            |of: fn(&wireloom_core::equilibrium::MinimiserResult) -> f64| end.map_or(0.0, |end| of(&end.minimiser));
        let tilting = Tilting {
            increments: INCREMENTS,
            failures,
            iterations: of_work(|work| work.iterations as f64) as usize,
            seconds: of_work(|work| work.seconds),
            contacts: end.map_or(0, |end| end.obstacles.iter().map(|body| body.contacts).sum()),
        };
        (counts, tilting)
    });
    let (nodes, joints) = touching.0;
    ContactCost { nodes, joints, triangles: body.triangles, touching: touching.1, alone: alone.1 }
}

const OBSTACLE: &str = "[[obstacles]]\nname = \"body\"\nmesh = \"body.stl\"\nposition = [1.05, 0, -0.055]\n";

/// A trunk along x with arms along y.
fn text(obstacle: &str) -> String {
    let mut text = String::from("schema = 1\nname = \"on a body\"\ngravity = [0, 0, 0]\n");
    for (name, diameter, bending) in [("trunk", 0.012, 0.02), ("arm", 0.006, 0.006)] {
        text += &format!(
            "[sections.{name}]\ndiameter = {diameter}\nlinear_density = 0.06\naxial_stiffness = 2e4\n\
             bending_stiffness = {bending}\n\
             torsion_stiffness = {bending}\n"
        );
    }
    let mut branch = |name: &str, from: &str, to: &str, length: f64| {
        let section = if name.starts_with("trunk") { "trunk" } else { "arm" };
        writeln!(
            text,
            "[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"{section}\"\n\
             length = {length}\n\
             max_segment = {SPACING}"
        )
        .expect("text takes everything");
    };
    let vertex = |k: usize| match k {
        0 => "A".to_owned(),
        k if k > JOINTS => "B".to_owned(),
        k => format!("J{k}"),
    };
    for k in 0..=JOINTS {
        branch(&format!("trunk-{k}"), &vertex(k), &vertex(k + 1), PITCH);
    }
    for k in 1..=JOINTS {
        for side in ["left", "right"] {
            branch(&format!("{side}-{k}"), &vertex(k), &format!("{side}-end-{k}"), ARM);
        }
    }
    for k in 1..=JOINTS {
        text += &format!(
            "[[joints]]\nname = \"J{k}\"\narms = [\n  {{ branch = \"trunk-{}\", direction = [-1, 0, 0], up = [0, 0, 1] \
             }},\n  \
             {{ branch = \"trunk-{k}\", direction = [1, 0, 0], up = [0, 0, 1] }},\n  \
             {{ branch = \"left-{k}\", direction = [0, 1, 0], up = [0, 0, 1] }},\n  \
             {{ branch = \"right-{k}\", direction = [0, -1, 0], up = [0, 0, 1] }},\n]\n",
            k - 1
        );
    }
    let plug = |text: &mut String, end: &str, [x, y]: [f64; 2], tangent: &str| {
        *text += &format!(
            "[[constraints]]\nname = \"plug-{end}\"\nkind = \"connector\"\nat = {{ end = \"{end}\" }}\n\
             position = [{x}, {y}, 0]\n\
             tangent = {tangent}\nup = [0, 0, 1]\n"
        );
    };
    plug(&mut text, "A", [0.0, 0.0], "[1, 0, 0]");
    plug(&mut text, "B", [PITCH * (JOINTS + 1) as f64, 0.0], "[1, 0, 0]");
    for k in (1..=JOINTS).step_by(2) {
        for (side, y) in [("left", 1.0), ("right", -1.0)] {
            let end = format!("{side}-end-{k}");
            plug(&mut text, &end, [PITCH * k as f64, y * ARM], &format!("[0, {y}, 0]"));
        }
    }
    text += obstacle;
    text += &format!(
        "[[steps]]\nname = \"sag\"\ngravity = [0, 0, -9.81]\n[[steps]]\nname = \"tilt\"\nincrements = {INCREMENTS}\n\
         gravity = [3, 2, -9.81]\n"
    );
    text
}

/// The file with the body.
struct Body {
    bytes: Vec<u8>,
    triangles: usize,
}

impl Body {
    /// A box as binary STL: under most of the harness.
    fn new() -> Self {
        let half = [0.9, 0.15, 0.05];
        let mut triangles: Vec<[[f32; 3]; 3]> = Vec::new();
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |i: usize, j: usize| {
                let mut x = [0.0_f32; 3];
                let at = |k: usize| 2.0 * k as f64 / DIVISIONS as f64 - 1.0;
                x[axis] = (side * half[axis]) as f32;
                (x[u], x[v]) = ((at(i) * half[u]) as f32, (side * at(j) * half[v]) as f32);
                x
            };
            for (i, j) in (0..DIVISIONS).flat_map(|i| (0..DIVISIONS).map(move |j| (i, j))) {
                let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let mut bytes = vec![0; 80];
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for corners in &triangles {
            bytes.extend([0; 12]);
            bytes.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        Self { bytes, triangles: triangles.len() }
    }
}

impl Files for Body {
    fn read(&self, path: &str) -> Result<String, String> {
        Err(format!("{path} is no text"))
    }

    fn bytes(&self, _: &str) -> Result<Vec<u8>, String> {
        Ok(self.bytes.clone())
    }
}

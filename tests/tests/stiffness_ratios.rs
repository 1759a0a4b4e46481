//! Stiff and soft parts in one harness: each is judged by itself, whatever it is joined to.

use wireloom::geometry::Vector;
use wireloom::{Run, Status, StepResult};
use wireloom_tests::cables::{branch, connector_along, run};

/// The last step of a run that converged.
fn end(run: &Run) -> &StepResult {
    let end = run.steps.last().expect("a step");
    assert_eq!((run.status(), end.status), (Status::Converged, Status::Converged), "{:?}", run.events);
    end
}

fn section(name: &str, density: f64, stretch: f64, bending: f64) -> String {
    format!(
        "[sections.{name}]\ndiameter = \"2 mm\"\nlinear_density = {density:e}\naxial_stiffness = {stretch:e}\n\
         bending_stiffness = {bending:e}\ntorsion_stiffness = {bending:e}\n"
    )
}

fn connector(end: &str, position: [f64; 3], tangent: [f64; 3], up: [f64; 3]) -> String {
    connector_along(&format!("plug-{end}"), end, position, tangent, up)
}

/// Position of the last node of a branch, m.
fn tip(end: &StepResult, branch: &str) -> Vector {
    let branch = end.branches.iter().find(|b| b.name == branch).expect("the branch");
    *branch.position.last().expect("nodes")
}

/// The force (N) that a constraint exerts.
fn reaction(end: &StepResult, constraint: &str) -> Vector {
    end.constraints.iter().find(|c| c.name == constraint).expect("the constraint").force
}

/// Two rods of this bending stiffness (N m²) in one line, and on their joint a wire that is ten times too heavy to
/// stand: `ρ g L³/EI` = 78, and 7.84 is what stands (Greenhill 1881).
fn wire_on_rods(bending: f64) -> String {
    let x = [1.0, 0.0, 0.0];
    let z = [0.0, 0.0, 1.0];
    [
        "schema = 1\nname = \"wire on rods\"\n".to_owned(),
        section("rod", 0.1, 1e6, bending),
        section("wire", 2e-3, 1e3, 2e-6),
        branch("left", ["A", "J"], "rod", 0.15, 15),
        branch("right", ["J", "B"], "rod", 0.15, 15),
        branch("wire", ["J", "W"], "wire", 0.2, 40),
        "[[joints]]\nname = \"J\"\nmodel = \"fused\"\narms = [\n\
         { branch = \"left\", direction = [-1, 0, 0], up = [0, 0, 1] },\n\
         { branch = \"right\", direction = [1, 0, 0], up = [0, 0, 1] },\n\
         { branch = \"wire\", direction = [0, 0, 1], up = [1, 0, 0] },\n]\n"
            .to_owned(),
        connector("A", [0.0, 0.0, 0.0], x, z),
        connector("B", [0.3, 0.0, 0.0], x, z),
    ]
    .concat()
}

#[test]
fn a_wire_that_cannot_stand_falls_whatever_it_stands_on() {
    let tips = [0.05, 50.0, 5e4].map(|bending| {
        let run = run(&wire_on_rods(bending));
        // To which side it falls is told by how the rods give way: by nothing, if they are stiff. Those of 50 N m² tell
        // it by 1e-9 of the energy: the run may stall on the way to that side.
        if bending == 50.0 && run.status() == Status::Stalled {
            return tip(run.steps.last().expect("a step"), "wire");
        }
        let end = end(&run);
        let told = (bending == 0.05).then_some(true);
        assert_eq!(end.stable, told, "on rods of {bending} N m²");
        tip(end, "wire")
    });
    // It hangs, head down, beside the rods; those of 50 N m² and more hardly bend under it.
    for tip in tips {
        assert!(tip.z < -0.15, "{tips:?}");
    }
    assert!((tips[1].z - tips[2].z).abs() < 1e-6, "{tips:?}");
}

/// A cable that sags between its plugs.
fn sagging() -> String {
    let z = [0.0, 0.0, 1.0];
    [
        "schema = 1\nname = \"sagging\"\n".to_owned(),
        section("cable", 0.05, 1e4, 0.01),
        branch("cable", ["A", "B"], "cable", 1.0, 60),
        connector("A", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], z),
        connector("B", [0.7, 0.1, 0.05], [0.8, 0.6, 0.0], z),
    ]
    .concat()
}

#[test]
fn a_stiff_bar_that_nothing_connects_changes_nothing() {
    let minimiser = "[minimiser]\nkind = \"newton\"\nforce_tolerance = 1e-10\n";
    let alone = run(&(sagging() + minimiser));
    for (stretch, bending) in [(1e9, 1e6), (1e10, 1e8)] {
        let bar = section("bar", 8.0, stretch, bending)
            + &branch("bar", ["C", "D"], "bar", 0.5, 10)
            + &connector("C", [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let beside = run(&(sagging() + &bar + minimiser));
        let (alone, beside) = (end(&alone), end(&beside));
        for plug in ["plug-A", "plug-B"] {
            let (expected, found) = (reaction(alone, plug), reaction(beside, plug));
            assert!((found - expected).norm() < 1e-7 * expected.norm(), "{plug}: {found:?} instead of {expected:?}");
        }
        let middle = |end: &StepResult| end.branches[0].position[30];
        assert!((middle(beside) - middle(alone)).norm() < 1e-9);
        assert_eq!((alone.stable, beside.stable), (Some(true), Some(true)));
    }
}

#[test]
fn a_soft_cable_joined_to_a_stiff_one_lies_where_it_does_when_solved_tightly() {
    let text = |tolerance: f64| {
        [
            "schema = 1\nname = \"soft on stiff\"\n".to_owned(),
            section("stiff", 5.0, 1e9, 1e6),
            section("soft", 0.05, 1e4, 0.01),
            branch("stiff", ["A", "J"], "stiff", 0.5, 20),
            branch("soft", ["J", "B"], "soft", 1.0, 60),
            "[[joints]]\nname = \"J\"\nmodel = \"fused\"\narms = [\n\
             { branch = \"stiff\", direction = [-1, 0, 0], up = [0, 0, 1] },\n\
             { branch = \"soft\", direction = [0.8, 0.6, 0], up = [0, 0, 1] },\n]\n"
                .to_owned(),
            connector("A", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            connector("B", [1.0, 0.5, 0.2], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            format!("[minimiser]\nkind = \"newton\"\nforce_tolerance = {tolerance:e}\n"),
        ]
        .concat()
    };
    let [loose, tight] = [1e-6, 1e-11].map(|tolerance| run(&text(tolerance)));
    let (loose, tight) = (end(&loose), end(&tight));
    let nodes = loose.branches[1].position.iter().zip(&tight.branches[1].position);
    let farthest = nodes.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(farthest < 1e-7, "{farthest} m");
    let (expected, found) = (reaction(tight, "plug-B"), reaction(loose, "plug-B"));
    assert!((found - expected).norm() < 1e-6 * expected.norm(), "{found:?} instead of {expected:?}");
}

/// A frame of two legs at right angles, 30 by 0.6 in section, clamped at one end and loaded in its plane at the other
/// with 0.9 of the load at which it buckles sideways (Argyris et al. 1979: 1.088), held off balance by a small load
/// across.
fn frame(tolerance: f64) -> String {
    [
        "schema = 1\nname = \"right-angle frame\"\ngravity = [0, 0, 0]\n[sections.strip]\ndiameter = 1\n\
         linear_density = 1\n\
         axial_stiffness = 1282320\nbending_stiffness = [38469.6, 9.61740e7]\ntorsion_stiffness = 58732\n"
            .to_owned(),
        branch("up", ["A", "J"], "strip", 240.0, 40),
        branch("out", ["J", "B"], "strip", 240.0, 40),
        "[[joints]]\nname = \"J\"\nmodel = \"fused\"\narms = [\n\
         { branch = \"up\", direction = [0, 0, -1], up = [1, 0, 0] },\n\
         { branch = \"out\", direction = [1, 0, 0], up = [0, 0, 1] },\n]\n"
            .to_owned(),
        connector("A", [0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        "[[loads]]\nname = \"in plane\"\nat = { end = \"B\" }\nforce = [0.9792, 0, 0]\nfactor = 0\n\
         [[loads]]\nname = \"across\"\nat = { end = \"B\" }\nforce = [0, 3e-4, 0]\nfactor = 0\n\
         [[steps]]\nname = \"load\"\nincrements = 10\n\
         [[steps.load]]\nload = \"in plane\"\nfactor = 1\n[[steps.load]]\nload = \"across\"\nfactor = 1\n"
            .to_owned(),
        format!("[minimiser]\nkind = \"newton\"\nforce_tolerance = {tolerance:e}\n"),
    ]
    .concat()
}

#[test]
fn near_a_limit_load_the_tolerance_does_not_decide_the_shape() {
    let across = [1e-5, 1e-8, 1e-11].map(|tolerance| {
        let run = run(&frame(tolerance));
        let end = end(&run);
        assert!(end.minimiser.shape_error.is_some_and(|error| error < 1e-7 * 240.0));
        tip(end, "out").y
    });
    assert!(across[2].abs() > 1e-3, "{across:?}");
    for found in &across[..2] {
        assert!((found / across[2] - 1.0).abs() < 1e-3, "{across:?}");
    }
}

#[test]
fn a_cable_that_hardly_stretches_converges() {
    for stretch in [1e8, 1e10] {
        let text = sagging().replace("axial_stiffness = 1e4", &format!("axial_stiffness = {stretch:e}"));
        assert!(text.contains(&format!("{stretch:e}")));
        end(&run(&text));
    }
}

/// A cable that hangs from one point may turn about the vertical for nothing.
#[test]
fn a_turn_that_costs_nothing_is_not_called_stable() {
    let text = [
        "schema = 1\nname = \"hung up\"\n".to_owned(),
        section("cable", 0.05, 1e4, 0.01),
        branch("cable", ["A", "B"], "cable", 0.6, 30).replace("segments", "curvature = [0, 3, 0]\nsegments"),
        "[[constraints]]\nname = \"nail\"\nkind = \"handle\"\nat = { end = \"A\" }\nposition = [0, 0, 0]\n".to_owned(),
    ]
    .concat();
    let run = run(&text);
    assert_eq!(end(&run).stable, None);
}

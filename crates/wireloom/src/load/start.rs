//! Faults that only the laid out harness shows.

use wireloom_scenario::{Built, Fault, Scenario};

/// Fault of a harness that is drawn within a body, at its deepest place.
pub(crate) fn refuse_inside(scenario: &Scenario, built: &Built) -> Option<Fault> {
    let inside = wireloom_solve::start::layout::inside(&built.network, &built.schedule)?;
    let body = &scenario.obstacles[inside.obstacle];
    let at = inside.position;
    Some(Fault {
        span: body.spans.of(Some("position")),
        message: format!(
            "the centre line of branch \"{}\" begins {:.1} mm inside obstacle \"{}\", at s = {:.4} m: [{:.4}, {:.4}, \
             {:.4}]",
            scenario.branches[inside.branch].name,
            1e3 * inside.depth,
            body.obstacle.name,
            inside.s,
            at.x,
            at.y,
            at.z
        ),
        help: "lay it outside, or write resolve = true in [contact] to have it pushed out first".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    const TEXT: &str = r#"
schema = 1
[sections.cable]
diameter = "8 mm"
linear_density = "120 g/m"
axial_stiffness = 2.0e4
bending_stiffness = 0.012
torsion_stiffness = 0.009
[[branches]]
name = "trunk"
from = "A"
to = "B"
section = "cable"
length = 1
segments = 50
path = [[0, 0, 0], [1, 0, 0]]
[[constraints]]
name = "plug-A"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[obstacles]]
name = "post"
shape = "box"
size = [0.2, 0.2, 0.2]
position = [0.5, 0, -0.07]
"#;

    #[test]
    fn a_harness_that_is_drawn_within_a_body_is_refused_unless_it_is_pushed_out() {
        let registry = crate::registry();
        let faults = crate::load(TEXT, &registry).err().expect("it is refused");
        let said = wireloom_scenario::render(TEXT, &faults);
        // Its axis is 30 mm below the top of the post.
        assert!(
            said.starts_with(
                "28:12: the centre line of branch \"trunk\" begins 30.0 mm inside obstacle \"post\", at s = "
            ),
            "{said}"
        );
        assert!(
            said.ends_with("help: lay it outside, or write resolve = true in [contact] to have it pushed out first\n")
        );
        assert!(crate::load(&format!("{TEXT}[contact]\nresolve = true\n"), &registry).is_ok());
        assert!(crate::load(&TEXT.replace("-0.07", "-0.2"), &registry).is_ok());
    }
}

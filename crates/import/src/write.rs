//! The scenario as TOML text, with comments on its rules.

use super::assembly::{self, Assembly};
use super::board::{self, Board, Peg};
use super::curve::Vector;
use super::document::Format;
use super::findings::Findings;
use super::harness::{Branch, Constraint, Harness, Place, Role, Section, SectionPart};
use super::options::{Arrangement, Options, Source};
use super::section::{Makeup, Types};
use super::tree::Tree;
use super::usage::Usage;
use nalgebra::UnitQuaternion;
use std::collections::HashSet;
use std::fmt::Write;
use wireloom_core::identity::{Identities, Identity, WireEnd};
use wireloom_scenario::adjust;

/// Number of points of the sweep over tolerances: enough for a yield within 3 % (one standard deviation).
const SAMPLES: usize = 200;

/// A number with `digits` significant digits, in the shortest form TOML reads as a float.
fn significant(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    // No negative zero.
    format!("{:?}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// A length or direction cosine, to 10⁻⁹.
fn fine(value: f64) -> String {
    let rounded = (value * 1e9).round() / 1e9;
    format!("{:?}", if rounded == 0.0 { 0.0 } else { rounded })
}

fn vector(v: &Vector) -> String {
    format!("[{}, {}, {}]", fine(v.x), fine(v.y), fine(v.z))
}

/// `[w, x, y, z]` with w ≥ 0.
fn quaternion(q: &UnitQuaternion<f64>) -> String {
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let [w, x, y, z] = [q.w, q.i, q.j, q.k].map(|c| fine(sign * c));
    format!("[{w}, {x}, {y}, {z}]")
}

/// A TOML basic string, on one line.
fn quoted(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 2);
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            // Of a line that the file has broken.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Text of the file in a comment: on one line, without control characters.
fn comment(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A fraction rounded down to 12 decimals, so that the fractions of an arm never add up to more than 1.
fn fraction(value: f64) -> String {
    format!("{:?}", (value * 1e12).floor() / 1e12)
}

/// Writes the scenario. Writing into a `String` cannot fail, hence the dropped results.
pub(super) fn scenario(
    harness: &Harness,
    format: &Format,
    options: &Options,
    usage: &[Usage],
    findings: &mut Findings,
) -> String {
    let tree = Tree::new(harness);
    let board = (options.arrangement != Arrangement::Installed)
        .then(|| board::lay(harness, &tree, options.memory_of_board(), findings));
    let mut out = String::new();
    header(&mut out, harness, format, options);
    if let (Some(Source { name, sha256 }), true) = (&options.file, format.is_written_back()) {
        let _ = writeln!(out, "\n# The KBL file, into which `wireloom export kbl` writes results back.\n[kbl]");
        let _ = writeln!(out, "file = {}\nsha256 = {}", quoted(name), quoted(sha256));
    }
    let name_of = |vertex: usize| &harness.vertices[vertex].name;
    write_types(&mut out, &harness.types);
    for section in &harness.sections {
        write_section(&mut out, section, &harness.types);
    }
    if let Some(accuracy) = options.accuracy {
        let _ = writeln!(out, "\n[mesh]\naccuracy = \"{} %\"", significant(accuracy * 1e2, 9));
    }
    for (index, branch) in harness.branches.iter().enumerate() {
        let _ = writeln!(out, "\n[[branches]] # {}", comment(&branch.remark));
        let _ = writeln!(out, "name = {}", quoted(&branch.name));
        let _ = writeln!(out, "from = {}\nto = {}", quoted(name_of(branch.ends[0])), quoted(name_of(branch.ends[1])));
        let _ = writeln!(out, "section = {}", quoted(&harness.sections[branch.section].name));
        write_parts(&mut out, branch, &harness.sections);
        let _ = writeln!(out, "length = {}", significant(branch.length, 9));
        write_text(&mut out, "kbl", branch.segment.as_deref());
        if options.accuracy.is_none() {
            let _ = writeln!(out, "max_segment = \"{} mm\"", significant(options.max_segment * 1e3, 9));
        }
        match &board {
            Some(board) => {
                let path: Vec<String> = board.path(harness, index).iter().map(vector).collect();
                if path.first() != path.last() {
                    let _ = writeln!(out, "path = [{}]", path.join(", "));
                }
                if options.arrangement == Arrangement::Assembly {
                    write_line(&mut out, "drawn", branch);
                }
            }
            None => write_line(&mut out, "path", branch),
        }
    }
    for (index, joint) in harness.joints.iter().enumerate() {
        let _ = writeln!(out, "\n[[joints]]\nname = {}\nmodel = \"cosserat\"\narms = [", quoted(name_of(joint.vertex)));
        for (k, arm) in joint.arms.iter().enumerate() {
            let rest = board.as_ref().map_or(&arm.orientation, |board| &board.arms[index][k]);
            let (branch, frame) = (quoted(&harness.branches[arm.branch].name), quaternion(rest));
            let _ = writeln!(out, "  {{ branch = {branch}, orientation = {frame} }},");
        }
        let _ = writeln!(out, "]");
        if !joint.wires.is_empty() {
            let _ = writeln!(out, "wires = [");
            for pair in &joint.wires {
                let [a, b] =
                    [pair.first, pair.second].map(|arm| quoted(&harness.branches[joint.arms[arm].branch].name));
                let wires = if pair.wires == 1 { "wire" } else { "wires" };
                let _ = writeln!(
                    out,
                    "  {{ between = [{a}, {b}], share = {} }}, # {} {wires}",
                    fraction(pair.fraction),
                    pair.wires
                );
            }
            let _ = writeln!(out, "]");
        }
    }
    match &board {
        Some(board) => write_board(&mut out, harness, &tree, board),
        None => (harness.constraints.iter().zip(&harness.identities))
            .for_each(|(constraint, identity)| write_constraint(&mut out, harness, constraint, identity)),
    }
    write_weights(&mut out, harness);
    if let (Some(board), Arrangement::Assembly) = (&board, options.arrangement) {
        write_steps(&mut out, harness, &tree, board, &assembly::plan(harness, &tree, options.order));
    }
    let _ = writeln!(out, "\n[minimiser]\nkind = \"newton\"");
    if options.arrangement == Arrangement::Assembly {
        let _ = writeln!(
            out,
            "max_iterations = {MAX_ITERATIONS} # for loose ends that fall far and parts that snap through"
        );
    }
    if options.arrangement == Arrangement::Board {
        write_not_held(&mut out, harness, &tree);
    }
    write_listed(&mut out, &harness.listed);
    write_tolerances(&mut out, harness);
    let _ = writeln!(
        out,
        "\n# Elements of the {} file: those that the computation depends on, those that are named here and do not \
         act, those\n# of other modules, and those that are not read.",
        format.name()
    );
    for Usage { kind, total, used, kept, left_out, not_read } in usage {
        let _ = writeln!(
            out,
            "# - {total} {}: {used} used, {kept} named, {left_out} of other modules, {not_read} not read",
            comment(kind)
        );
    }
    if !findings.list.is_empty() {
        let _ = writeln!(out, "\n# Irregularities of the {} file, and their treatment:", format.name());
        for finding in &findings.list {
            let _ = writeln!(out, "# - {}", comment(&finding.to_string()));
        }
    }
    out
}

/// Writes part number and the like.
fn write_identity(out: &mut String, identity: &Identity) {
    let Identity { part, description, supplier, colour } = identity;
    for (key, text) in [("part", part), ("description", description), ("supplier", supplier), ("colour", colour)] {
        write_text(out, key, text.as_deref());
    }
}

/// Writes a text, if there is one that is not blank.
fn write_text(out: &mut String, key: &str, text: Option<&str>) {
    if let Some(text) = text {
        let _ = writeln!(out, "{key} = {}", quoted(text));
    }
}

/// Writes connectors and fixings as components that do not act: on the board only pegs hold the harness.
fn write_not_held(out: &mut String, harness: &Harness, tree: &Tree) {
    for (constraint, identity) in harness.constraints.iter().zip(&harness.identities) {
        if matches!(constraint.at, Place::End(vertex) if tree.roots.contains(&vertex)) {
            continue;
        }
        let kind = if constraint.role == Role::Connector { "connector" } else { "fixing" };
        let _ = writeln!(out, "\n[[components]]\nname = {}\nkind = \"{kind}\"", quoted(&constraint.name));
        write_identity(out, identity);
        match constraint.at {
            Place::End(vertex) | Place::Joint(vertex) => {
                write_text(out, "vertex", Some(&harness.vertices[vertex].name));
            }
            Place::Along { branch, s } => {
                write_text(out, "branch", Some(&harness.branches[branch].name));
                let s = significant(s, 9);
                let _ = writeln!(out, "from = {s}\nto = {s}");
            }
        }
    }
}

/// Writes components that do not act, and wires.
fn write_listed(out: &mut String, listed: &Identities) {
    for component in &listed.components {
        let _ = writeln!(out, "\n[[components]]\nname = {}", quoted(&component.name));
        write_text(out, "kind", component.kind.as_deref());
        write_identity(out, &component.identity);
        write_text(out, "connector", component.connector.as_deref());
        write_text(out, "cavity", component.cavity.as_deref());
        write_text(out, "vertex", component.vertex.as_deref());
        write_text(out, "branch", component.branch.as_deref());
        for (key, s) in [("from", component.from), ("to", component.to)] {
            if let Some(s) = s {
                let _ = writeln!(out, "{key} = {}", significant(s, 9));
            }
        }
    }
    for connection in &listed.connections {
        let _ = writeln!(out, "\n[[connections]]\nname = {}", quoted(&connection.name));
        write_text(out, "signal", connection.signal.as_deref());
        write_text(out, "wire", connection.wire.as_deref());
        write_identity(out, &connection.identity);
        let ends: Vec<String> = connection.ends.iter().map(wire_end).collect();
        if !ends.is_empty() {
            let _ = writeln!(out, "ends = [{}]", ends.join(", "));
        }
        let branches: Vec<String> = connection.branches.iter().map(|name| quoted(name)).collect();
        if !branches.is_empty() {
            let _ = writeln!(out, "branches = [{}]", branches.join(", "));
        }
    }
}

fn wire_end(end: &WireEnd) -> String {
    let WireEnd { connector, cavity, terminal, seal } = end;
    let keys = [("connector", connector), ("cavity", cavity), ("terminal", terminal), ("seal", seal)];
    let given: Vec<String> =
        keys.into_iter().filter_map(|(key, text)| Some(format!("{key} = {}", quoted(text.as_ref()?)))).collect();
    format!("{{ {} }}", given.join(", "))
}

/// The tolerances of lengths as a sweep in comments.
fn write_tolerances(out: &mut String, harness: &Harness) {
    let mut varied = String::new();
    for branch in &harness.branches {
        let Some([least, greatest]) = branch.tolerance.filter(|[least, greatest]| least < greatest) else { continue };
        let key = quoted(&format!("branches.{}.length", adjust::quoted(&branch.name)));
        let [from, to] = [least, greatest].map(|deviation| significant(branch.length + deviation, 9));
        let _ = writeln!(varied, "# {key} = {{ from = {from}, to = {to} }}");
    }
    if !varied.is_empty() {
        let _ = writeln!(
            out,
            "\n# Tolerances of lengths in the file, as a sweep. To switch it on, remove `# ` from the lines \
             below.\n\
             # [sweep]\n# method = \"latin-hypercube\"\n# samples = {SAMPLES}\n# [sweep.vary]\n{varied}\
             # End of the sweep."
        );
    }
}

fn write_types(out: &mut String, types: &Types) {
    let _ = writeln!(
        out,
        "\n# Wires and coverings of the file; values that the file does not give are like those of the library."
    );
    for (family, name, keys) in types
        .wires
        .iter()
        .map(|wire| ("wires", &wire.name, &wire.keys))
        .chain(types.coverings.iter().map(|covering| ("coverings", &covering.name, &covering.keys)))
    {
        if !keys.is_empty() {
            let _ = writeln!(out, "\n[{family}.{}]", quoted(name));
            for (key, value) in keys {
                let _ = writeln!(out, "{key} = {value}");
            }
        }
    }
}

fn write_section(out: &mut String, section: &Section, types: &Types) {
    let _ = writeln!(out, "\n[sections.{}] # {}", quoted(&section.name), comment(&section.remark));
    let wires = section.makeup.wires.iter().map(|(kind, count)| {
        let name = quoted(&types.wires[*kind].name);
        if *count == 1 { format!("{{ type = {name} }}") } else { format!("{{ type = {name}, count = {count} }}") }
    });
    let wires: Vec<String> = wires.collect();
    if wires.len() < 3 {
        let _ = writeln!(out, "wires = [{}]", wires.join(", "));
    } else {
        let _ = writeln!(out, "wires = [\n  {},\n]", wires.join(",\n  "));
    }
    let coverings = section.makeup.coverings.iter().map(|kind| quoted(&types.coverings[*kind].name));
    let coverings: Vec<String> = coverings.collect();
    if !coverings.is_empty() {
        let _ = writeln!(out, "covering = [{}]", coverings.join(", "));
    }
    // It replaces the one by the rule, which is larger where the file asks for less.
    let radius = section.makeup.bend_radius.map(|_| Makeup::micrometres(types.bundle(&section.makeup).min_bend_radius));
    for (key, radius) in [("min_bend_radius", radius), ("min_bend_radius_moving", section.makeup.moving_bend_radius)] {
        if let Some(radius) = radius {
            let _ = writeln!(out, "{key} = {}", Makeup::written(radius));
        }
    }
}

/// Writes the parts of a branch that have another section.
fn write_parts(out: &mut String, branch: &Branch, sections: &[Section]) {
    let part = |part: &SectionPart| {
        let end = |key: &str, place: f64, end: f64| {
            if place == end { String::new() } else { format!(", {key} = {}", significant(place, 9)) }
        };
        let ends = end("from", part.range[0], 0.0) + &end("to", part.range[1], branch.length);
        format!("  {{ section = {}{ends} }},\n", quoted(&sections[part.section].name))
    };
    let parts: String = branch.parts.iter().map(part).collect();
    if !parts.is_empty() {
        let _ = writeln!(out, "sections = [\n{parts}]");
    }
}

/// Writes the drawn centre line of a branch.
fn write_line(out: &mut String, key: &str, branch: &Branch) {
    let mut points: Vec<String> = branch.path.iter().map(vector).collect();
    points.dedup();
    if points.len() > 1 {
        let _ = writeln!(out, "{key} = [\n  {},\n]", points.join(",\n  "));
    }
}

/// Name of the constraint that holds a root of the harness.
fn root_holder(harness: &Harness, root: usize) -> String {
    let plug = harness.constraints.iter().find(|constraint| constraint.at == Place::End(root));
    plug.map_or_else(|| format!("board {}", harness.vertices[root].name), |plug| plug.name.clone())
}

/// The harness on the board: the roots held rigidly, everything else by elastic pegs.
fn write_board(out: &mut String, harness: &Harness, tree: &Tree, board: &Board) {
    for &root in &tree.roots {
        let is_joint = harness.joints.iter().any(|joint| joint.vertex == root);
        let at = if is_joint { Place::Joint(root) } else { Place::End(root) };
        let _ = writeln!(out, "\n[[constraints]] # the root, held rigidly on the board");
        // A joint has no frame that a connector could hold; the pegs beside it keep it from turning.
        let kind = if is_joint { "handle" } else { "connector" };
        let _ = writeln!(out, "name = {}\nkind = \"{kind}\"", quoted(&root_holder(harness, root)));
        let _ = writeln!(out, "at = {}\nposition = {}", place(harness, at), vector(&board.points[root]));
        let branch = harness.branches.iter().position(|branch| branch.ends.contains(&root));
        if let Some(branch) = branch.filter(|_| !is_joint) {
            let frame = board.frame(harness, branch, root);
            let _ = writeln!(out, "tangent = {}", vector(&(frame * Vector::z())));
            let _ = writeln!(out, "up = {}", vector(&(frame * Vector::x())));
        }
        let plug = harness.constraints.iter().position(|constraint| constraint.at == Place::End(root));
        plug.into_iter().for_each(|plug| write_identity(out, &harness.identities[plug]));
    }
    for peg in &board.pegs {
        let _ = writeln!(out, "\n[[constraints]]\nname = {}\nkind = \"handle\"", quoted(&peg.name));
        let _ = writeln!(out, "at = {}", place(harness, peg.at));
        let _ = writeln!(out, "position = {}\nstiffness = {:?}", vector(&peg.position), Peg::STIFFNESS);
    }
}

/// Writes `release = […]`, if there is anything to release.
fn write_release(out: &mut String, names: &[String]) {
    if !names.is_empty() {
        let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
        let _ = writeln!(out, "release = [{}]", names.join(", "));
    }
}

/// Writes the motion of a constraint to its final place.
fn write_final_move(out: &mut String, constraint: &Constraint) {
    let _ = writeln!(out, "[[steps.move]]\nconstraint = {}", quoted(&constraint.name));
    let _ = writeln!(out, "position = {}", vector(&constraint.position));
    let _ = writeln!(out, "tangent = {}", vector(&(constraint.frame * Vector::z())));
    if constraint.role == Role::Connector {
        let _ = writeln!(out, "up = {}", vector(&(constraint.frame * Vector::x())));
    }
}

fn write_steps(out: &mut String, harness: &Harness, tree: &Tree, board: &Board, assembly: &Assembly) {
    let hand = |vertex: usize| format!("hand {}", harness.vertices[vertex].name);
    let _ = writeln!(out, "\n[[steps]]\nname = \"lift off the board\"\nincrements = 1");
    write_release(out, &board.pegs.iter().map(|peg| peg.name.clone()).collect::<Vec<_>>());
    for &vertex in &assembly.hands {
        let _ = writeln!(out, "[[steps.add]]\nname = {}\nkind = \"handle\"", quoted(&hand(vertex)));
        let _ = writeln!(out, "at = {}", place(harness, Place::Joint(vertex)));
    }
    let _ = writeln!(out, "\n[[steps]]\nname = \"carry to the vehicle\"");
    let _ = writeln!(out, "increments = {}", Assembly::CARRY_INCREMENTS);
    for constraint in &harness.constraints {
        if matches!(constraint.at, Place::End(vertex) if tree.roots.contains(&vertex)) {
            write_final_move(out, constraint);
        }
    }
    // A piece without connectors is held at its first vertex until its clips hold it.
    let plugged = |root: usize| harness.constraints.iter().any(|constraint| constraint.at == Place::End(root));
    let bare: Vec<usize> = tree.roots.iter().copied().filter(|&root| !plugged(root)).collect();
    for &root in &bare {
        let _ = writeln!(out, "[[steps.move]]\nconstraint = {}", quoted(&root_holder(harness, root)));
        let _ = writeln!(out, "position = {}", vector(&harness.vertices[root].position));
    }
    for &vertex in &assembly.hands {
        let _ = writeln!(out, "[[steps.move]]\nconstraint = {}", quoted(&hand(vertex)));
        let _ = writeln!(out, "position = {}", vector(&harness.vertices[vertex].position));
    }
    for install in &assembly.installs {
        let constraint = &harness.constraints[install.constraint];
        let verb = if constraint.role == Role::Connector { "plug" } else { "clip" };
        let _ = writeln!(out, "\n[[steps]] # {}", comment(&constraint.remark));
        let _ = writeln!(out, "name = {}", quoted(&format!("{verb} {}", constraint.name)));
        let _ = writeln!(out, "increments = {}", Assembly::INSTALL_INCREMENTS);
        write_release(out, &install.released.iter().map(|&vertex| hand(vertex)).collect::<Vec<_>>());
        let operation = if constraint.role == Role::Connector { "mate" } else { "clip" };
        let _ = writeln!(out, "[[steps.{operation}]]\nname = {}", quoted(&constraint.name));
        write_seat(out, harness, constraint);
        write_identity(out, &harness.identities[install.constraint]);
        write_text(out, "kbl", constraint.assignment.as_deref());
    }
    let installed = assembly.installs.iter().map(|install| harness.constraints[install.constraint].at);
    let clipped: HashSet<usize> = installed.map(|at| tree.root_of(harness, at)).collect();
    let mut last: Vec<String> = assembly.last.iter().map(|&vertex| hand(vertex)).collect();
    last.extend(bare.into_iter().filter(|root| clipped.contains(root)).map(|root| root_holder(harness, root)));
    if !last.is_empty() {
        let _ = writeln!(out, "\n[[steps]]\nname = \"let go\"\nincrements = 1");
        write_release(out, &last);
    }
    write_untwist(out, harness, assembly);
}

/// Writes steps that remove whole turns of twist. Each connector was turned to its seat by the shortest turn, so
/// whole turns of twist remain that depend on the order. At the end all connectors except those of the roots are
/// released to turn freely, and then turned to their seats again.
fn write_untwist(out: &mut String, harness: &Harness, assembly: &Assembly) {
    let installed = assembly.installs.iter().map(|install| &harness.constraints[install.constraint]);
    let plugs: Vec<&Constraint> = installed.filter(|constraint| constraint.role == Role::Connector).collect();
    if plugs.is_empty() {
        return;
    }
    let turning = |plug: &Constraint| format!("turning {}", plug.name);
    let _ = writeln!(out, "\n[[steps]] # every connector is released and turns freely in its place");
    let _ = writeln!(out, "name = \"take the twist out\"\nincrements = 1");
    write_release(out, &plugs.iter().map(|plug| plug.name.clone()).collect::<Vec<_>>());
    for plug in &plugs {
        let _ = writeln!(out, "[[steps.grasp]]\nname = {}", quoted(&turning(plug)));
        let _ = writeln!(out, "at = {}\nhold = [\"position\", \"tangent\"]", place(harness, plug.at));
    }
    let _ = writeln!(out, "\n[[steps]]\nname = \"plug all in again\"");
    let _ = writeln!(out, "increments = {}", Assembly::INSTALL_INCREMENTS);
    write_release(out, &plugs.iter().map(|plug| turning(plug)).collect::<Vec<_>>());
    for plug in &plugs {
        let _ = writeln!(out, "[[steps.add]]\nname = {}\nkind = \"connector\"", quoted(&plug.name));
        let _ = writeln!(out, "at = {}", place(harness, plug.at));
        write_final_move(out, plug);
    }
}

fn write_constraint(out: &mut String, harness: &Harness, constraint: &Constraint, identity: &Identity) {
    let _ = writeln!(out, "\n[[constraints]] # {}", comment(&constraint.remark));
    let _ = writeln!(out, "name = {}", quoted(&constraint.name));
    let kind = if constraint.role == Role::Connector { "connector" } else { "collar" };
    let _ = writeln!(out, "kind = \"{kind}\"");
    write_seat(out, harness, constraint);
    write_identity(out, identity);
    write_text(out, "kbl", constraint.assignment.as_deref());
}

/// Writes the place that a constraint attaches to, and the pose that it holds.
fn write_seat(out: &mut String, harness: &Harness, constraint: &Constraint) {
    let _ = writeln!(out, "at = {}", place(harness, constraint.at));
    let _ = writeln!(out, "position = {}", vector(&constraint.position));
    if let Place::Joint(_) = constraint.at {
        return;
    }
    let tangent = vector(&(constraint.frame * Vector::z()));
    let _ = writeln!(out, "tangent = {tangent}");
    match constraint.role {
        Role::Connector => drop(writeln!(out, "up = {}", vector(&(constraint.frame * Vector::x())))),
        Role::Clip => {}
        Role::Guide => drop(writeln!(out, "rail = [{tangent}]")),
    }
}

fn place(harness: &Harness, at: Place) -> String {
    let name_of = |vertex: usize| quoted(&harness.vertices[vertex].name);
    match at {
        Place::End(vertex) => format!("{{ end = {} }}", name_of(vertex)),
        Place::Joint(vertex) => format!("{{ joint = {} }}", name_of(vertex)),
        Place::Along { branch, s } => {
            format!("{{ branch = {}, s = {} }}", quoted(&harness.branches[branch].name), significant(s, 9))
        }
    }
}

/// Largest number of iterations of an increment of an assembly. If a part falls far, more iterations help more than
/// smaller increments.
const MAX_ITERATIONS: usize = 4000;

/// Standard gravity along −z, m/s².
const GRAVITY: f64 = 9.81;

/// Writes the weights of connectors, which matter while they hang.
fn write_weights(out: &mut String, harness: &Harness) {
    for constraint in harness.constraints.iter().filter(|constraint| constraint.mass > 0.0) {
        let name = format!("weight of {}", constraint.name);
        let _ = writeln!(out, "\n[[loads]]\nname = {}\nat = {}", quoted(&name), place(harness, constraint.at));
        let _ = writeln!(out, "force = [0.0, 0.0, {}]", significant(-GRAVITY * constraint.mass, 4));
    }
}

fn header(out: &mut String, harness: &Harness, format: &Format, options: &Options) {
    let [built, drawn] = format.lengths();
    let _ = writeln!(
        out,
        "# Made from a {} by wireloom-import. SI units: m, kg, N, N m².
#
# Lengths: {built} where the file gives it, else {drawn}, which is that of the drawn curve.
# Paths: from `from` to `to`; branches are straight at rest.
# {} contains no stiffness. Sections follow from their wires and coverings by the rule of the library, with a factor of
# about two of uncertainty in bending; `wireloom check` prints the values and bounds. Where it matters, write measured
# values (bending_stiffness, torsion_stiffness, …) beside the wires: they take precedence over the rule.
# Joints: two arms are coupled by their common wires: share = Σ common EI / Σ EI of the wires of the arm named first.",
        format.title(),
        format.name()
    );
    let _ = match options.arrangement {
        Arrangement::Installed => writeln!(
            out,
            "# Drawn: paths are the drawn centre lines. Every branch has one untwisted frame field along its path; \
             arms and\n# connectors take theirs from it."
        ),
        Arrangement::Board | Arrangement::Assembly => writeln!(
            out,
            "# On the board: paths are those there. At rest the arms of joints have the angles of the board, with a \
             memory of {}\n# (1: built flat and at rest there; 0: the drawn angles).",
            significant(options.memory_of_board(), 9)
        ),
    };
    let _ = writeln!(out, "\nschema = 1\nname = {}", quoted(&harness.name));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_as_floats() {
        assert_eq!(significant(0.1 + 0.2, 9), "0.3");
        assert_eq!(significant(12345678.0, 4), "12350000.0");
        assert_eq!(significant(1.23456e-7, 4), "1.235e-7");
        assert_eq!(fine(-1e-12), "0.0");
        assert_eq!(fine(2.835768688), "2.835768688");
        assert_eq!(fraction(1.0), "1.0");
    }

    #[test]
    fn thirds_do_not_add_up_to_more_than_one() {
        let third: f64 = fraction(1.0 / 3.0).parse().unwrap();
        assert!(third + third + third <= 1.0);
    }

    #[test]
    fn text_of_the_file_cannot_break_out() {
        let hostile = "a\"b\\c\nd = 1";
        let table: toml::Table = toml::from_str(&format!("x = {} # {}", quoted(hostile), comment(hostile))).unwrap();
        assert_eq!(table["x"].as_str(), Some("a\"b\\c d = 1"), "on one line");
        assert_eq!(table.len(), 1);
    }
}

//! `report.html`.

use crate::samples::{among_obstacles, broken, failing, run, v, y_harness};
use wireloom_core::Status;
use wireloom_core::equilibrium::{OperationResult, Outcome, PartFamily, PartFault, Run, SpanResult, StationResult};
use wireloom_export::report::{Report, write};

fn page(run: &Run, texts: &[(String, String)]) -> String {
    let report = Report { run, obstacles: &[], texts, program: "wireloom 0", machine: "a machine", written: "today" };
    let mut bytes = vec![];
    write(&report, &mut bytes).expect("written");
    String::from_utf8(bytes).expect("UTF-8")
}

/// Names of elements in order; every one that opens is closed where it must be.
fn elements(page: &str) -> Vec<String> {
    let void = ["meta", "img", "!DOCTYPE", "?xml"];
    let (mut open, mut names) = (vec![], vec![]);
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').expect("a tag ends");
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().expect("a name").to_owned();
        if tag.starts_with('/') {
            assert_eq!(open.pop().as_deref(), Some(name.as_str()), "…{tag}…");
        } else {
            names.push(name.clone());
            if !tag.ends_with('/') && !void.contains(&name.as_str()) {
                open.push(name.clone());
            }
        }
        rest = after;
        if ["script", "style"].contains(&name.as_str()) && !tag.starts_with('/') {
            rest = &rest[rest.find(&format!("</{name}>")).expect("it ends")..];
        }
    }
    assert!(open.is_empty(), "{open:?}");
    names
}

fn texts() -> Vec<(String, String)> {
    vec![("s.toml".into(), "name = \"</pre><script>alert(1)</script>\"".into())]
}

/// Every station has a row, a span its place, a fault its sentence.
#[test]
fn stations_spans_and_faults_are_told() {
    let mut step = y_harness();
    let station = |x: f64| StationResult { position: v(0.0, 0.0, x), force: v(x, 0.0, 0.0), moment: v(0.0, 0.0, 0.0) };
    step.constraints[0].stations = vec![station(1.0), station(12.345)];
    let (force, largest) = (v(0.0, 0.0, 2.0), v(0.0, 0.0, 1.0));
    step.constraints[1].span =
        Some(SpanResult { branch: "trunk".into(), range: (0.1, 0.25), force, largest, largest_at: 0.2 });
    let mut run = run("y-harness", vec![step]);
    let [name, kind, step] = ["tie", "cable-tie", "pull"].map(str::to_owned);
    let family = PartFamily::Constraint;
    run.outcome = Outcome::Fault(PartFault { family, name, kind, step, increment: 3, message: "it broke".into() });
    let page = page(&run, &texts());
    elements(&page);
    for told in [
        "plug-A, station 2",
        "12.345",
        "trunk from s = 100",
        "constraint `tie` (cable-tie) in step `pull`, increment 3: it broke",
    ] {
        assert!(page.contains(told), "{told}");
    }
}

#[test]
fn operations_have_a_table_where_there_are_any() {
    let mut step = y_harness();
    assert!(!page(&run("y-harness", vec![step.clone()]), &texts()).contains("Operations"));
    let plug = "plug-B".to_owned();
    step.operations =
        vec![OperationResult::Mate { constraint: plug, insertion_force: Some(31.5), own: None, limit: None }];
    let page = page(&run("y-harness", vec![step]), &texts());
    elements(&page);
    assert!(page.contains("<td>mate</td><td>plug-B</td><td>insertion force 31.50 N (cable alone"));
}

/// The verdict is the first thing on the page and the status the second; both stand before anything of the run.
#[test]
fn the_sheet_comes_first_and_status_and_verdict_are_two_things() {
    let run = failing();
    let page = page(&run, &texts());
    std::fs::write(format!("{}/failing.html", env!("CARGO_TARGET_TMPDIR")), &page).expect("written");
    elements(&page);
    let body = &page[page.find("<body>").expect("a body")..];
    let at = |words: &str| body.find(words).unwrap_or_else(|| panic!("no {words}"));
    let order = [
        "<p class=\"sign verdict fail\">",
        "<strong>FAIL</strong>2 of 5 requirements fail, 1 is unresolved, 1 not checked, 1 that should be kept fails",
        "<p class=\"sign status pass\">",
        "<strong>converged</strong>",
        "id=\"requirements\"",
        "id=\"events\"",
    ];
    let places = order.map(at);
    assert!(places.is_sorted(), "{places:?}");
    // The worst first; its step leads to the picture.
    let sheet = &body[at("class=\"sheet\"")..at("id=\"events\"")];
    let rows: Vec<&str> = sheet.split("<tr").skip(2).collect();
    let names = ["wire", "trunk pull", "gap", "push", "hand", "plug-A"];
    let found: Vec<&str> = rows.iter().filter_map(|row| row.split("</td>").nth(1)).collect();
    assert_eq!(found, names.map(|name| format!("<td>{name}")), "{found:?}");
    for words in
        ["14.4 mm", "min 45 mm", "-68 %", "± 0.40 mm", "VW &lt;60306&gt;", "<a href=\"#picture-1\">equilibrium (1)</a>"]
    {
        assert!(rows[0].contains(words), "{words}: {}", rows[0]);
    }
    assert!(rows[0].starts_with(" class=\"fail\">") && rows[2].starts_with(" class=\"unresolved\">"));
    assert!(rows[2].contains("the discretisation error reaches over the limit"));
    assert!(rows[4].contains("FAIL (should)") && rows[4].starts_with(" class=\"unresolved\">"), "{}", rows[4]);
    assert_eq!(page.matches("id=\"picture-1\"").count(), 1);
}

/// The same harness that keeps everything is green, and not if its run stopped early.
#[test]
fn a_sheet_that_is_kept_is_green_only_if_the_run_converged() {
    let mut run = failing();
    run.requirements.truncate(1);
    assert!(page(&run, &[]).contains("class=\"sign verdict pass\"><small>verdict on the harness</small><strong>PASS"));
    run.outcome = Outcome::Graded(Status::Interrupted);
    let page = page(&run, &[]);
    assert!(page.contains("class=\"sign verdict unresolved\"") && page.contains("class=\"sign status fail\""));
}

#[test]
fn of_a_long_sheet_what_is_kept_is_folded() {
    let mut run = failing();
    let kept = run.requirements[0].clone();
    run.requirements.extend((0..100).map(|_| kept.clone()));
    let page = page(&run, &[]);
    elements(&page);
    assert!(page.contains("<summary>102 requirements that are kept or were not checked</summary>"));
}

#[test]
fn tells_all_of_a_run_and_needs_no_other_file() {
    let page = page(&run("y-harness", vec![y_harness()]), &texts());
    let names = elements(&page);
    assert_eq!(names.iter().filter(|name| *name == "script").count(), 1, "what the scenario says is text");
    assert!(page.contains("&lt;/pre&gt;&lt;script&gt;alert(1)"));
    for word in ["wireloom 0", "a machine", "today", "a remark", "bent too tightly", "converged", "s.toml"] {
        assert!(page.contains(word), "{word}");
    }
    let step = y_harness();
    for name in step.constraints.iter().map(|c| &c.name).chain(step.branches.iter().map(|b| &b.name)) {
        let escaped = name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
        assert!(page.contains(&format!(">{escaped}<")), "{name}");
    }
    assert_eq!(names.iter().filter(|name| *name == "figure").count(), 2 * step.branches.len());
    for source in page.split("src=\"").skip(1) {
        assert!(source.starts_with("data:image/svg+xml;base64,"), "{}", &source[..40]);
    }
    for target in page.split("href=\"").skip(1) {
        let id = target.strip_prefix('#').and_then(|t| t.split('"').next()).expect("a place on the page");
        assert_eq!(page.matches(&format!("id=\"{id}\"")).count(), 1, "{id}");
    }
}

#[test]
fn the_branch_nearest_to_its_limit_comes_first() {
    let step = y_harness();
    let share = |b: &wireloom_core::equilibrium::BranchResult| {
        let least = b.bend_radius.iter().copied().fold(f64::INFINITY, f64::min);
        b.bend_radius_limit.map_or(0.0, |limit| limit / least)
    };
    let first = step.branches.iter().max_by(|a, b| share(a).total_cmp(&share(b))).expect("branches").name.clone();
    let page = page(&run("y", vec![step]), &[]);
    assert!(page.contains(&format!("<a href=\"#b0\">{first}</a>")), "{first}");
}

#[test]
fn whatever_the_names_and_numbers_are_it_is_a_page() {
    let mut step = broken();
    step.name = "<b>&\"'\u{1b}[31m".into();
    let page = page(&run("<img src=x onerror=alert(1)>", vec![step]), &[]);
    elements(&page);
    assert!(!page.contains("<img src=x") && page.contains("&lt;b&gt;&amp;"));
}

#[test]
fn a_run_without_results_has_a_page() {
    elements(&page(&run("nothing", vec![]), &[]));
}

#[test]
fn many_steps_have_pictures_where_something_happened() {
    let steps: Vec<_> = (0..60)
        .map(|k| {
            let mut step = y_harness();
            step.name = format!("step {k}");
            step
        })
        .collect();
    let page = page(&run("long", steps), &[]);
    // The event of the sample is of step 1; the first and the last are always drawn.
    assert_eq!(page.matches("data:image/svg+xml").count(), 3);
    assert!(page.contains("Pictures of 57 steps are omitted"));
}

#[test]
fn what_touches_and_what_is_near_is_told() {
    let page = page(&among_obstacles(), &texts());
    elements(&page);
    for told in
        ["<td>floor</td>", "1.500", "obstacle `post`", "branch `left` at s = 125.0 mm", "<td class=\"n\">4.5</td>"]
    {
        assert!(page.contains(told), "{told}");
    }
    assert!(!self::page(&run("alone", vec![y_harness()]), &texts()).contains("Clearance"));
}

/// They had the tightest bend of a shape that was on its way to the equilibrium.
#[test]
fn branches_have_the_values_of_equilibria_alone() {
    let branches = |page: &str| {
        let (_, section) = page.split_once("<section id=\"branches\">").expect("the section");
        section.split("</section>").next().expect("its end").to_owned()
    };
    let mut lost = y_harness();
    (lost.name, lost.status) = ("lost".into(), Status::IterationLimit);
    let rows = branches(&page(&run("y-harness", vec![y_harness(), lost.clone()]), &texts()));
    assert!(rows.contains("<td>equilibrium</td>") && !rows.contains("lost"), "{rows}");
    for branch in &mut lost.branches {
        branch.bend_radius.fill(1e-3);
    }
    assert_eq!(branches(&page(&run("y-harness", vec![y_harness(), lost.clone()]), &texts())), rows);
    let page = page(&run("y-harness", vec![lost]), &texts());
    elements(&page);
    let none = branches(&page);
    assert!(none.contains("No step ended in an equilibrium.") && !none.contains("<table>"), "{none}");
}

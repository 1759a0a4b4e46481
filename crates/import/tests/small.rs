//! A small KBL file of our own: what comes out of it, which errors its broken forms give, and that no broken form
//! panics.

#[path = "small/arranged.rs"]
mod arranged;
mod common;
#[path = "small/identities.rs"]
mod identities;
#[path = "common/mutated.rs"]
mod mutations;

use common::checked;
use mutations::mutated;
use wireloom_core::identity::{Identified, Identities, Identity, WireEnd};
use wireloom_import::kbl::{Arrangement, Contents, ImportError, Imported, Options, Order, Selection, contents, import};
use wireloom_scenario::bundle::{Bundle, Covered, Layer, Wire, Wires};
use wireloom_scenario::{shipped_coverings, shipped_wires};

const SMALL: &str = include_str!("small.kbl");

fn imported(text: &str) -> Imported {
    import(text, &Options::default()).unwrap()
}

fn parsed(text: &str) -> toml::Table {
    toml::from_str(&imported(text).scenario).unwrap()
}

fn with(old: &str, new: &str) -> String {
    assert!(SMALL.contains(old), "{old}");
    SMALL.replacen(old, new, 1)
}

fn refused(text: &str) -> String {
    import(text, &Options::default()).unwrap_err().to_string()
}

/// Line and column of the first occurrence, from 1, as messages give them.
fn place(text: &str, what: &str) -> String {
    let before = &text[..text.find(what).unwrap()];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    format!("{}:{}", before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

fn float(value: &toml::Value) -> f64 {
    value.as_float().unwrap()
}

fn close(value: &toml::Value, expected: f64, tolerance: f64) {
    let found = value.as_float().unwrap();
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} instead of {expected}");
}

/// A wire of the library with these, m and kg/m.
fn like(name: &str, outside: f64, density: f64, radius: f64) -> Wire {
    let mut wire = shipped_wires().find(|(shipped, _)| *shipped == name).unwrap().1.clone();
    wire.layers = vec![Layer { diameter: outside, ..wire.layers[0] }];
    (wire.measured.linear_density, wire.measured.min_bend_radius) = (Some(density), Some(radius));
    wire
}

fn thin() -> Wire {
    like("FLRY-B 0.5", 1.6e-3, 0.006, 0.005)
}

fn core() -> Wire {
    like("FLRY-B 1.0", 2e-3, 0.012, 0.008)
}

#[test]
fn branches_have_the_lengths_and_paths_of_their_segments() {
    let scenario = parsed(SMALL);
    assert_eq!(scenario["name"].as_str(), Some("small y"));
    let branches = scenario["branches"].as_array().unwrap();
    let expected =
        [("trunk", "A", "J", 0.3079), ("left", "B", "J", 0.26), ("right", "J", "C", 0.25), ("stub", "J", "S", 0.03)];
    for (branch, (name, from, to, length)) in branches.iter().zip(expected) {
        assert_eq!(["name", "from", "to"].map(|key| branch[key].as_str().unwrap()), [name, from, to]);
        close(&branch["length"], length, 1e-9);
        assert_eq!(branch["max_segment"].as_str(), Some("10.0 mm"));
    }
    // The parabola of the trunk is 60 mm/2 high in its middle and 307.9 mm long: 31 steps of at most 10 mm.
    let path = branches[0]["path"].as_array().unwrap();
    assert_eq!(path.len(), 32);
    assert_eq!((float(&path[0][0]), float(&path[31][0])), (0.0, 0.3));
    let top = path.iter().map(|point| float(&point[1])).fold(0.0, f64::max);
    assert!((0.0299..=0.03).contains(&top), "{top}");
}

/// Two modules, of which each has wires of its own; plug A is in every car. The second is configured beside itself, and
/// names a wire by its connection, and a part that is not there.
fn modular() -> String {
    with(
        "  </Harness>",
        r#"    <Module id="mod1"><Part_number>L-1</Part_number><Description>left</Description>
      <Module_configuration id="mc1"><Logistic_control_information>K8S</Logistic_control_information>
        <Controlled_components>w1 w4 plugB spliceS</Controlled_components></Module_configuration></Module>
    <Module id="mod2"><Part_number>R-1</Part_number></Module>
    <Module_configuration id="mc2"><Controlled_components>c2 wc clip tape1 gone</Controlled_components>
      <Modules>mod2</Modules></Module_configuration>
    <Module id="mod3"><Part_number>/NULL</Part_number></Module>
    <Harness_configuration id="v1"><Part_number>/OVMM</Part_number>
      <Car_classification_level_4>plain</Car_classification_level_4><Modules>mod2</Modules></Harness_configuration>
    <Harness_configuration id="v2"><Part_number>/OVMM</Part_number>
      <Car_classification_level_4>full</Car_classification_level_4><Modules>mod1 mod2</Modules></Harness_configuration>
    <Harness_configuration id="v3"><Part_number>/OVMM</Part_number><Modules></Modules></Harness_configuration>
  </Harness>"#,
    )
}

fn selected(selection: Selection) -> Result<Imported, ImportError> {
    import(&modular(), &Options { selection, ..Options::default() })
}

#[test]
fn modules_and_variants_are_listed_by_the_names_that_tell_them_apart() {
    let Contents { modules, variants } = contents(&modular()).unwrap();
    let listed: Vec<_> = modules.iter().map(|module| (module.name.as_str(), module.parts)).collect();
    assert_eq!(listed, [("L-1", 4), ("R-1", 5), ("mod3", 0)]);
    assert_eq!(modules[0].option_code.as_deref(), Some("K8S"));
    let listed: Vec<_> = variants.iter().map(|variant| (variant.name.as_str(), variant.modules.join(" "))).collect();
    assert_eq!(listed, [("plain", "R-1".to_owned()), ("full", "L-1 R-1".to_owned()), ("v3", String::new())]);
}

#[test]
fn a_variant_has_the_parts_of_its_modules_and_no_segments_without_wires() {
    let names = |imported: &Imported, key: &str| -> Vec<String> {
        let scenario: toml::Table = toml::from_str(&imported.scenario).unwrap();
        let entries = scenario.get(key).and_then(|list| list.as_array().cloned()).unwrap_or_default();
        entries.iter().map(|entry| entry["name"].as_str().unwrap().to_owned()).collect()
    };
    let density = |imported: &Imported| {
        let built = checked(&imported.scenario);
        built.sections.iter().map(|section| section.linear_density).fold(0.0, f64::max)
    };
    let plain = selected(Selection::Variant("plain".to_owned())).unwrap();
    assert_eq!(names(&plain, "branches"), ["trunk", "right"]);
    assert_eq!(names(&plain, "constraints"), ["plug A", "clip-1"]);
    let said: Vec<String> = plain.findings.iter().map(ToString::to_string).collect();
    assert!(said.contains(&"of the 3 modules of the harness 1 are taken".to_owned()), "{said:?}");
    assert!(said.iter().any(|line| line.contains("no wires of the chosen modules") && line.contains("s2, s4")));

    let left = selected(Selection::Modules(vec!["L-1".to_owned()])).unwrap();
    assert_eq!(names(&left, "branches"), ["trunk", "left", "stub"]);
    assert_eq!(names(&left, "constraints"), ["plug A", "plug B"]);

    assert!(said.iter().any(|line| line.contains("parts that are not in the file") && line.contains("gone")));
    // In the trunk one thin wire on the left, on the right such a wire and a core; in `left` two.
    assert!(left.scenario.contains("1 wire, 0.50 mm² copper") && !left.scenario.contains("3 wires"));
    assert!(plain.scenario.contains("2 wires, 1.50 mm² copper") && !plain.scenario.contains("3 wires"));
    assert!(density(&left) < density(&plain), "{} {}", density(&left), density(&plain));
    let full = selected(Selection::Variant("full".to_owned())).unwrap();
    let all = selected(Selection::All).unwrap();
    assert_eq!(names(&full, "branches"), names(&all, "branches"));
    assert_eq!((density(&full), names(&full, "constraints")), (density(&all), names(&all, "constraints")));
}

#[test]
fn modules_that_there_are_not_are_refused_with_those_that_there_are() {
    let said = |selection: Selection| selected(selection).unwrap_err().to_string();
    let modules = |names: &[&str]| Selection::Modules(names.iter().map(|name| (*name).to_owned()).collect());
    assert_eq!(said(modules(&["R-1", "L-2"])), "there is no module \"L-2\"; did you mean `L-1`?");
    assert_eq!(
        said(Selection::Variant("empty".to_owned())),
        "there is no variant \"empty\"; known: `plain`, `full`, `v3`"
    );
    assert!(
        said(Selection::Variant("v3".to_owned()))
            .ends_with("the variant \"v3\" has no modules; choose some by their names")
    );
    assert!(said(modules(&["mod3"])).starts_with("the chosen modules have no wires"));
}

/// Default tolerances, and one of its own for the trunk.
const TOLERANCES: &str = r#"
  <Default_dimension_specification id="tol-t1">
    <Dimension_value_range id="tol-v1"><Unit_component>uMM</Unit_component>
      <Minimum>0</Minimum><Maximum>100</Maximum></Dimension_value_range>
    <Tolerance_type>segment length</Tolerance_type>
    <Tolerance_indication id="tol-i1">
      <Lower_limit id="tol-l1"><Unit_component>uMM</Unit_component><Value_component>-2</Value_component></Lower_limit>
      <Upper_limit id="tol-u1"><Unit_component>uMM</Unit_component><Value_component>3</Value_component></Upper_limit>
    </Tolerance_indication>
  </Default_dimension_specification>
  <Default_dimension_specification id="tol-t2">
    <Tolerance_indication id="tol-i2">
      <Lower_limit id="tol-l2"><Unit_component>uMM</Unit_component><Value_component>-5</Value_component></Lower_limit>
      <Upper_limit id="tol-u2"><Unit_component>uMM</Unit_component><Value_component>5</Value_component></Upper_limit>
    </Tolerance_indication>
  </Default_dimension_specification>
  <Default_dimension_specification id="tol-t3">
    <Tolerance_type>wire length</Tolerance_type>
    <Tolerance_indication id="tol-i3">
      <Upper_limit id="tol-u3"><Unit_component>uMM</Unit_component><Value_component>50</Value_component></Upper_limit>
    </Tolerance_indication>
  </Default_dimension_specification>
  <Dimension_specification id="tol-t4">
    <Segments>s1</Segments>
    <Tolerance_indication id="tol-i4">
      <Upper_limit id="tol-u4"><Unit_component>uMM</Unit_component><Value_component>10</Value_component></Upper_limit>
    </Tolerance_indication>
  </Dimension_specification>
  <Dimension_specification id="tol-t5">
    <Segments>s1 s2</Segments>
    <Tolerance_indication id="tol-i5">
      <Upper_limit id="tol-u5"><Unit_component>uMM</Unit_component><Value_component>1</Value_component></Upper_limit>
    </Tolerance_indication>
  </Dimension_specification>
"#;

/// In comments at first: the scenario runs as before. Without them it is a sweep that is accepted.
#[test]
fn tolerances_of_lengths_are_a_sweep_in_comments() {
    let text = with("  <Harness id=", &format!("{TOLERANCES}  <Harness id="));
    let found = imported(&text);
    assert!(checked(&found.scenario).sweep.is_none());
    let findings: Vec<String> = found.findings.iter().map(ToString::to_string).collect();
    assert!(
        findings.iter().any(|finding| finding.contains("not those of one segment") && finding.contains("tol-t5")),
        "{findings:?}"
    );
    let begin = found.scenario.find("# [sweep]").expect("a sweep");
    let end = found.scenario.find("# End of the sweep.").expect("its end");
    let (before, rest) = found.scenario.split_at(begin);
    let on: String = rest[..end - begin].lines().map(|line| format!("{}\n", &line[2..])).collect();
    let on = format!("{before}{on}{}", &found.scenario[end..]);
    assert!(checked(&on).sweep.is_some());
    let on: toml::Table = toml::from_str(&on).unwrap();
    let varied = on["sweep"]["vary"].as_table().unwrap();
    let expected = [("trunk", 0.3079, 0.3179), ("left", 0.255, 0.265), ("right", 0.245, 0.255), ("stub", 0.028, 0.033)];
    assert_eq!(varied.len(), expected.len(), "{varied:?}");
    for (branch, from, to) in expected {
        let range = &varied[&format!("branches.{branch}.length")];
        close(&range["from"], from, 1e-9);
        close(&range["to"], to, 1e-9);
    }
    assert_eq!(on["sweep"]["samples"].as_integer(), Some(200));
}

#[test]
fn sections_follow_the_rule() {
    let scenario = checked(&imported(SMALL).scenario);
    let section = |i: usize| &scenario.sections[scenario.branches[i].section];
    let (thin, core) = (thin(), core());
    let wires = |count: usize| [Wires { wire: &thin, count }, Wires { wire: &core, count: 1 }];
    let mut tape = shipped_coverings().find(|(name, _)| *name == "pvc tape, half lap").unwrap().1.clone();
    tape.measured.linear_density = Some(0.004);
    // Two wires, the core with half of its cable, tape over the first half of the length.
    let trunk = Bundle::new(&wires(2), &[Covered { covering: &tape, fraction: 1.0 }], None, None);
    let bare = Bundle::new(&wires(2), &[], None, None);
    let right = Bundle::new(&wires(1), &[], None, None);
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found}, not {expected}");
    near(section(0).bending_stiffness[0], trunk.bending.taken);
    near(section(0).torsion_stiffness, trunk.torsion.taken);
    near(section(0).axial_stiffness, trunk.axial_stiffness);
    near(section(0).diameter, trunk.diameter);
    near(section(0).linear_density, 0.006 + 0.006 + 0.012 + 0.004);
    let [part] = scenario.branches[0].parts[..] else { panic!("{:?}", scenario.branches[0].parts) };
    let behind = &scenario.sections[part.section];
    near(behind.bending_stiffness[0], bare.bending.taken);
    near(behind.linear_density, 0.006 + 0.006 + 0.012);
    near(part.range[0], 0.15395);
    near(part.range[1], 0.3079);
    assert!(scenario.branches[1..].iter().all(|branch| branch.parts.is_empty()));
    near(section(2).bending_stiffness[0], right.bending.taken);
    near(section(3).diameter, 0.0016);
    near(section(3).bending_stiffness[0], thin.bending_stiffness().taken);
    near(section(3).min_bend_radius.unwrap(), 0.005);
}

#[test]
fn sections_are_written_as_what_is_inside() {
    let text = imported(SMALL).scenario;
    let expected = "
[wires.\"0.5 mm², 1.6 mm\"]
like = \"FLRY-B 0.5\"
linear_density = \"6 g/m\"
min_bend_radius = \"5 mm\"

[wires.\"1 mm², 2 mm\"]
like = \"FLRY-B 1.0\"
layers = [{ material = \"pvc\", diameter = \"2 mm\" }]
linear_density = \"12 g/m\"
min_bend_radius = \"8 mm\"

[coverings.\"test tape\"]
like = \"pvc tape, half lap\"
linear_density = \"4 g/m\"

[sections.\"3-wires\"] # 3 wires, 2.00 mm² copper
wires = [{ type = \"0.5 mm², 1.6 mm\", count = 2 }, { type = \"1 mm², 2 mm\" }]
covering = [\"test tape\"]

[sections.\"3-wires-2\"] # 3 wires, 2.00 mm² copper
wires = [{ type = \"0.5 mm², 1.6 mm\", count = 2 }, { type = \"1 mm², 2 mm\" }]
";
    assert!(text.contains(expected), "{text}");
    let parts = "section = \"3-wires\"\nsections = [\n  { section = \"3-wires-2\", from = 0.15395 },\n]\n";
    assert!(text.contains(parts), "{text}");
}

/// Coverings were averaged over their segment: a tube over half of it made all of it half as stiff, and as thick.
#[test]
fn coverings_are_where_the_file_says() {
    let area = "<Protection_area id=\"pa1\"><Start_location>0</Start_location><End_location>0.5</End_location>";
    let covered = |areas: &[[f64; 2]]| {
        let area_of = |(k, [from, to]): (usize, &[f64; 2])| {
            let own = area.replace("pa1", &format!("pa{}", k + 1));
            let own = own.replace(">0<", &format!(">{from}<")).replace(">0.5<", &format!(">{to}<"));
            own + "<Associated_protection>tape1</Associated_protection></Protection_area>"
        };
        let areas: String = areas.iter().enumerate().map(area_of).collect();
        imported(&with(
            &format!("{area}<Associated_protection>tape1</Associated_protection></Protection_area>"),
            &areas,
        ))
    };
    let parts = |areas: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let scenario = checked(&covered(areas).scenario);
        let part = |part: &wireloom_scenario::SectionPart| part.range.map(|s| (s / 0.3079 * 1e6).round() / 1e6);
        scenario.branches[0].parts.iter().map(part).collect()
    };
    // The parts that are taped are the other ones where most is bare.
    assert_eq!(parts(&[[0.1, 0.3]]), [[0.1, 0.3]]);
    assert_eq!(parts(&[[0.3, 0.1], [0.2, 0.4]]), [[0.1, 0.4]]);
    assert_eq!(parts(&[[0.1, 0.2], [0.2, 0.3], [0.6, 0.7]]), [[0.1, 0.3], [0.6, 0.7]]);
    assert_eq!(parts(&[[0.0, 0.3], [0.4, 1.0]]), [[0.3, 0.4]]);
    assert_eq!(parts(&[[0.0, 1.0]]), [[0.0; 2]; 0]);
    // An end within half of a diameter of the clip at the middle is at the clip.
    assert_eq!(parts(&[[0.0, 0.505], [0.8, 0.9]]), [[0.5, 0.8], [0.9, 1.0]]);
    assert_eq!(parts(&[[0.0, 0.52], [0.8, 0.9]]), [[0.52, 0.8], [0.9, 1.0]]);
    // 1.5 mm of bare wires of 4 mm, between and at the end.
    assert_eq!(parts(&[[0.0, 0.5], [0.505, 0.995]]), [[0.0; 2]; 0]);
    let found = covered(&[[0.0, 0.5], [0.505, 0.995]]).findings;
    let told = found.iter().map(ToString::to_string).find(|finding| finding.contains("shorter than they are thick"));
    assert!(told.is_some_and(|finding| finding.contains("s1 (1.5 mm)")), "{found:?}");
}

/// The findings of an import.
fn findings(text: &str) -> Vec<String> {
    imported(text).findings.iter().map(ToString::to_string).collect()
}

/// What stood behind a comment or processing instruction was lost, with the ways of wires and the digits of lengths.
#[test]
fn a_comment_within_a_text_does_not_cut_it() {
    let divided = with("<Segments>s1 s2</Segments>", "<Segments>s1 <!-- then -->s2</Segments>")
        .replace(">307.9<", ">307.<?note?>9<")
        .replace("<Part>core1<", "<Part><!-- first -->core1<");
    assert_ne!(divided, SMALL);
    assert_eq!(parsed(&divided), parsed(SMALL));
}

#[test]
fn a_segment_without_wires_does_not_have_minus_zero_copper() {
    let without = with("<Segments>s4 s2</Segments>", "");
    let scenario = imported(&without).scenario;
    assert!(
        scenario.contains("] # 1 wire, though the file routes none here") && !scenario.contains("-0.00 mm²"),
        "{scenario}"
    );
}

/// They were said to cover no segment.
#[test]
fn coverings_of_a_segment_without_a_length_of_its_own_cover_it() {
    let found = findings(&with("<Value_component>307.9<", "<Value_component>0<"));
    assert!(!found.iter().any(|finding| finding.contains("cover no segment")), "{found:#?}");
}

/// They were taken, the first one cut to what a scenario may have.
#[test]
fn masses_that_cannot_be_are_told_and_left_out() {
    let heavy = "<Unit_component>uKG</Unit_component><Value_component>60000<";
    let tape = with("<Unit_component>uGM</Unit_component><Value_component>4<", heavy)
        .replace("<Unit id=\"uM\">", "<Unit id=\"uKG\"><Unit_name>kg</Unit_name></Unit><Unit id=\"uM\">");
    let found = findings(&tape);
    let what = "Wire_protection_occurrence `tape1`: 60000 kg on a length of 0.155 m is impossible; left out";
    assert!(found.iter().any(|finding| finding == what), "{found:#?}");
    let wire = with(
        "<Unit_component>uGM</Unit_component><Value_component>6<",
        "<Unit_component>uGM</Unit_component><Value_component>60<",
    );
    let found = findings(&wire);
    let what = "General_wire `part1`: its mass is 60.0 g/m, and solid copper of its outside diameter would have \
                18.0 g/m; left out";
    assert!(found.iter().any(|finding| finding == what), "{found:#?}");
    let what = "wires without usable mass per length; estimated: General_wire `part1`";
    assert!(found.iter().any(|finding| finding.contains(what)), "{found:#?}");
}

/// It was a bundle of the cores that are routed, with their diameters and bend radii.
#[test]
fn a_cable_counts_with_its_jacket_wherever_one_of_its_cores_runs() {
    let jacket = "<Bend_radius id=\"rj\"><Unit_component>uMM</Unit_component><Value_component>48</Value_component>\
                  </Bend_radius><Outside_diameter id=\"dj\"><Unit_component>uMM</Unit_component><Value_component>9\
                  </Value_component></Outside_diameter>";
    let one = with("<Core id=\"core1\">", &format!("{jacket}<Core id=\"core1\">"));
    let both = one
        .replace("<Connection id=\"c4\">", "<Connection id=\"c5\"><Wire>w5</Wire></Connection><Connection id=\"c4\">")
        .replace(
            "</Core_occurrence>",
            "</Core_occurrence><Core_occurrence id=\"w5\"><Part>core2</Part></Core_occurrence>",
        )
        .replace(
            "<Routing id=\"q4\">",
            "<Routing id=\"q5\"><Routed_wire>c5</Routed_wire><Segments>s3 s1</Segments></Routing>\
                                         <Routing id=\"q4\">",
        );
    let whole = with("<Wire>w3</Wire>", "<Wire>wc</Wire>")
        .replace("<Core id=\"core1\">", &format!("{jacket}<Core id=\"core1\">"));
    for text in [&one, &both, &whole] {
        let scenario = imported(text).scenario;
        let cable = "[wires.\"2 mm², 9 mm\"]\n";
        let (_, own) = scenario.split_once(cable).unwrap_or_else(|| panic!("{scenario}"));
        let own = own.split("\n\n").next().unwrap();
        for value in ["linear_density = \"24 g/m\"", "min_bend_radius = \"48 mm\"", "diameter = \"9 mm\""] {
            assert!(own.contains(value), "{own}");
        }
        // In the trunk with two wires, once.
        assert!(scenario.contains("count = 2 }, { type = \"2 mm², 9 mm\" }]"), "{scenario}");
    }
}

/// A covering like none that is known counts with its mass.
#[test]
fn coverings_that_are_not_known_are_reported() {
    let odd = with("<Protection_type>TAPE", "<Protection_type>FOAM").replace("test tape", "foam \"block\"");
    let found = imported(&odd);
    let findings: Vec<String> = found.findings.iter().map(ToString::to_string).collect();
    assert!(
        findings.contains(&"coverings unlike any of the library; only their mass counts: `foam \"block\"`".into()),
        "{findings:?}"
    );
    let (with_foam, with_tape) = (checked(&found.scenario), checked(&imported(SMALL).scenario));
    assert_eq!(with_foam.sections[0].linear_density, with_tape.sections[0].linear_density);
    assert!(with_foam.sections[0].bending_stiffness[0] < with_tape.sections[0].bending_stiffness[0]);
}

#[test]
fn joints_know_which_wires_pass() {
    let scenario = parsed(SMALL);
    let joint = &scenario["joints"][0];
    let shares: Vec<(&str, &str, f64)> = joint["wires"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| (pair["between"][0].as_str().unwrap(), pair["between"][1].as_str().unwrap(), float(&pair["share"])))
        .collect();
    // A trunk of three wires, half of it taped, is stiffer than its wires by more than arms of two, those by more
    // than one wire: the arm with the smaller factor is named first.
    assert_eq!(
        shares.iter().map(|(a, b, _)| (*a, *b)).collect::<Vec<_>>(),
        [("left", "trunk"), ("right", "trunk"), ("stub", "left")]
    );
    assert_eq!((shares[0].2, shares[1].2, shares[2].2), (0.5, 1.0, 1.0));
}

#[test]
fn arms_and_connectors_point_as_drawn() {
    let scenario = parsed(SMALL);
    let arms = scenario["joints"][0]["arms"].as_array().unwrap();
    // The trunk comes in along (150, −60, 0) with d1 = z: a turn from x, y, z to d1, d2, d3.
    let [w, x, y, z]: [f64; 4] = std::array::from_fn(|i| float(&arms[0]["orientation"][i]));
    let d1 = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)];
    let d3 = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
    let norm = 150.0_f64.hypot(60.0);
    for (found, expected) in d1.iter().chain(&d3).zip([0.0, 0.0, 1.0, 150.0 / norm, -60.0 / norm, 0.0]) {
        assert!((found - expected).abs() < 1e-8, "{d1:?} {d3:?}");
    }
    let constraints = scenario["constraints"].as_array().unwrap();
    assert_eq!(
        constraints.iter().map(|c| c["name"].as_str().unwrap()).collect::<Vec<_>>(),
        ["plug A", "plug B", "clip-1"]
    );
    // `tangent` is d3 from → to: at B, where the branch starts, into the harness.
    close(&constraints[1]["tangent"][0], -2.0 / 5.0_f64.sqrt(), 1e-8);
    assert_eq!(constraints[1]["up"].as_array().unwrap().iter().map(float).collect::<Vec<_>>(), [0.0, 0.0, 1.0]);
    close(&constraints[2]["at"]["s"], 0.15395, 1e-8);
    close(&constraints[2]["position"][0], 0.15, 1e-6);
    close(&constraints[2]["tangent"][0], 1.0, 1e-8);
}

#[test]
fn every_irregularity_is_reported() {
    let findings: Vec<String> = imported(SMALL).findings.iter().map(ToString::to_string).collect();
    let expected = [
        "parts of elements that are not read (2 of them): 1 Bend_radius, 1 Outside_diameter",
        "coverings are replaced by those of the library (tapes by half lap unless they say otherwise), with the file's \
         masses and diameters: `test tape`: pvc tape, half lap",
        "segments without usable centre curve; straight from node to node (2 of them): s2, s4",
        "Physical_length (taken) and Virtual_length differ: s2 (260.0 and 250.0 mm)",
        "stale centre curves, which miss their nodes and contain no piece that fits between them; straight from node \
         to node: s3 (by 251.0 mm)",
        "ends carry no component; left free: n4",
        "ends carry splices (wires joined within the harness, without a counterpart); left free: n5 (spliceS S1)",
    ];
    assert_eq!(findings, expected);
}

/// The file with further clips on the trunk, at these fractions of it, drawn at these x (mm) on its straight chord.
fn clipped(clips: &[(f64, f64, &str)]) -> String {
    let mut text = SMALL.to_owned();
    for (i, (share, x, kind)) in clips.iter().enumerate() {
        let assignment = format!(
            "<Fixing_assignment id=\"g{i}\"><Location>{share}</Location><Fixing>more{i}</Fixing></Fixing_assignment>"
        );
        text = text.replace("<Protection_area", &format!("{assignment}<Protection_area"));
        // The parabola y = 0.4 x (1 − x/300): the clip stands on it.
        let y = 0.4 * x * (1.0 - x / 300.0);
        let placed = format!(
            "<Fixing_occurrence id=\"more{i}\"><Id>more-{i}</Id><Placement id=\"mp{i}\"><V>1</V><V>0</V><V>0</V>\
             <Cartesian_point>mq{i}</Cartesian_point></Placement><Part>mf{i}</Part></Fixing_occurrence>"
        );
        text = text
            .replace("<General_wire_occurrence id=\"w1\">", &format!("{placed}<General_wire_occurrence id=\"w1\">"));
        let point = format!(
            "<Fixing id=\"mf{i}\"><Fixing_type>{kind}</Fixing_type></Fixing><Cartesian_point id=\"mq{i}\">\
             <Coordinates>{x}</Coordinates><Coordinates>{y}</Coordinates><Coordinates>0</Coordinates></Cartesian_point>"
        );
        text = text.replace("<General_wire id=\"part1\">", &format!("{point}<General_wire id=\"part1\">"));
    }
    text
}

#[test]
fn clips_are_seated_where_they_are_drawn_and_along_their_channel() {
    // Stated at 0.75 of the trunk, drawn at x = 240 of 300 mm, with a channel along x.
    let text = clipped(&[(0.75, 240.0, "CLIP")]);
    let scenario = parsed(&text);
    let clip = &scenario["constraints"][3];
    assert_eq!(clip["name"].as_str(), Some("more-0"));
    close(&clip["position"][0], 0.240, 1e-6);
    assert_eq!(clip["tangent"].as_array().unwrap().iter().map(float).collect::<Vec<_>>(), [1.0, 0.0, 0.0]);
    // Arc length of the parabola from 0 to 240 mm, by its formula, of 307.9 mm (307.87 mm drawn).
    let arc = |x: f64| {
        let slope = 0.4 - 0.8 * x / 300.0;
        -(slope * slope.hypot(1.0) + slope.asinh()) * 300.0 / 1.6
    };
    let drawn = arc(300.0) - arc(0.0);
    close(&clip["at"]["s"], (arc(240.0) - arc(0.0)) / drawn * 0.3079, 1e-6);
    assert!(imported(&text).findings.iter().any(|finding| finding.what.contains("beside the places stated")));
}

#[test]
fn a_channel_across_the_cable_is_reported_and_not_used() {
    let text = clipped(&[(0.8, 240.0, "CLIP")]).replace("<V>1</V><V>0</V>", "<V>0</V><V>1</V>");
    let slope = 0.4 - 0.8 * 240.0 / 300.0_f64;
    close(&parsed(&text)["constraints"][3]["tangent"][1], slope / slope.hypot(1.0), 1e-5);
    assert!(imported(&text).findings.iter().any(|finding| finding.what.contains("channels of fixings do not lie")));
}

#[test]
fn ducts_and_clips_close_to_others_leave_the_cable_free_along_itself() {
    // The trunk is 4 mm thick or so: 20 mm from the clip in its middle is too close, 90 mm is not.
    let scenario = parsed(&clipped(&[(0.57, 170.0, "CLIP"), (0.8, 240.0, "CLIP"), (0.2, 60.0, "CABLE_DUCT")]));
    let free: Vec<(&str, bool)> = scenario["constraints"].as_array().unwrap()[2..]
        .iter()
        .map(|c| (c["name"].as_str().unwrap(), c.get("rail").is_some_and(|rail| rail[0] == c["tangent"])))
        .collect();
    assert_eq!(free, [("more-2", true), ("clip-1", false), ("more-0", true), ("more-1", false)]);
}

#[test]
fn connectors_weigh_and_what_is_not_used_is_listed() {
    let text = with("<Id>plug B</Id>", "<Id>plug B</Id><Part>housing</Part>").replace(
        "<General_wire id=\"part1\">",
        "<Connector_housing id=\"housing\"><Mass_information id=\"hm\"><Unit_component>uG</Unit_component>\
         <Value_component>50</Value_component></Mass_information></Connector_housing>\
         <Cavity_seal id=\"seal\"><Part_number>1</Part_number><Colour><Value>x</Value></Colour></Cavity_seal>\
         <General_wire id=\"part1\">",
    );
    let text =
        text.replace("<Unit id=\"uM\">", "<Unit id=\"uG\"><Si_unit_name>gram</Si_unit_name></Unit><Unit id=\"uM\">");
    let text = text.replace(
        "<General_wire_occurrence id=\"w1\">",
        "<Fixing_occurrence id=\"spare\"><Id>spare clip</Id></Fixing_occurrence><Connector_occurrence id=\"lost\"/>\
         <General_wire_occurrence id=\"w1\">",
    );
    let scenario = parsed(&text);
    assert_eq!(scenario["loads"][0]["at"]["end"].as_str(), Some("B"));
    close(&scenario["loads"][0]["force"][2], -0.05 * 9.81, 1e-3);
    let findings: Vec<String> = imported(&text).findings.iter().map(ToString::to_string).collect();
    for said in [
        "fixings are assigned to no segment; left out: spare `spare clip`",
        "connectors sit at no node; left out: lost `lost`",
        "elements that are not read: 1 Cavity_seal",
    ] {
        assert!(findings.iter().any(|finding| finding == said), "{said}: {findings:#?}");
    }
}

#[test]
fn what_a_harness_can_do_without_is_a_finding() {
    let found = |text: &str, what: &str| {
        let findings = imported(text).findings;
        assert!(findings.iter().any(|finding| finding.to_string().contains(what)), "{what}: {findings:#?}");
    };
    found(&with("<Unit_name>GramPerMetre</Unit_name>", "<Unit_name>ounce</Unit_name>"), "the unknown unit `uGM`");
    found(
        &with(
            "<Unit_component>uMM</Unit_component><Value_component>307.9",
            "<Unit_component>uGM</Unit_component><Value_component>307.9",
        ),
        "a mass per length, not a length",
    );
    found(&with("<Wire>w1</Wire>", "<Wire>nobody</Wire>"), "`nobody` is not the id of a `General_wire_occurrence`");
    found(&with("<Segments>s1 s2</Segments>", ""), "wires are routed through no segment; they are not counted: w1");
    found(&with("<Segments>s4 s2</Segments>", ""), "no wires are routed through segments");
    found(&with("<Segments>s4 s2</Segments>", ""), "an arm of these joints has no routed wires");
    found(
        &with("<Segments>s1 s2</Segments>", "<Segments>s1</Segments>"),
        "wires end inside joints, where nothing holds them: n2 w1",
    );
    found(
        &with("<Control_points>pA pA1 pJ<", "<Control_points>pA nowhere pJ<"),
        "`nowhere` is not the id of a `Cartesian_point`",
    );
    found(
        &with("<Location>0.5</Location>", "<Location>1.5</Location>"),
        "fixings are placed outside their segments; left out: s1 f1 `clip-1` at 1.5",
    );
    found(
        &with("<Coordinates>150</Coordinates><Coordinates>30<", "<Coordinates>150</Coordinates><Coordinates>330<"),
        "than a clip reaches; left out: s1 f1 `clip-1` (300 mm)",
    );
    found(
        &with("<Referenced_components>plugA<", "<Referenced_components>ghost<"),
        "component `ghost`, which is not in the file",
    );
    found(&with("<Value_component>155<", "<Value_component>255<"), "tape1 (255.0 mm, places 15");
}

#[test]
fn refusals_name_place_and_cure() {
    let broken = with("</Harness>", "</Harnes>");
    assert!(
        refused(&broken).starts_with(&format!("{}: not well-formed XML", place(&broken, "</Harnes>"))),
        "{}",
        refused(&broken)
    );

    assert_eq!(refused("<svg/>"), "1:1: the root element is `svg`; a KBL file has `KBL_container` there");

    let broken = with("<Coordinates>300<", "<Coordinates>30o<");
    assert_eq!(
        refused(&broken),
        format!(
            "{}: `30o` in `Coordinates` is not a finite decimal number of size 1e8 or less",
            place(&broken, "<Coordinates>30o")
        )
    );

    let broken = with("<Cartesian_point>pB</Cartesian_point>", "<Cartesian_point>plugB</Cartesian_point>");
    assert_eq!(
        refused(&broken),
        format!(
            "{}: `plugB` is not the id of a `Cartesian_point` of this file (it is that of a `Connector_occurrence`)",
            place(&broken, "<Cartesian_point>plugB")
        )
    );

    let broken = with("<Start_node>n3</Start_node>", "");
    assert_eq!(
        refused(&broken),
        format!(
            "{}: Segment `s2` has no `Start_node`; a segment runs from one node to another",
            place(&broken, "<Segment id=\"s2\"")
        )
    );

    let broken = with("<Start_node>n3</Start_node>", "<Start_node>n2</Start_node>");
    assert!(
        refused(&broken).ends_with("segment `s2` starts and ends at node `n2`; a branch joins two different vertices")
    );

    let broken = with("<Node id=\"n4\"", "<Node id=\"n3\"");
    assert!(refused(&broken).contains("the id `n3` is already that of the element at line"));

    assert!(refused("<KBL_container/>").contains("the file has no `Segment`"));
    let options = Options { max_segment: 0.0, ..Options::default() };
    assert_eq!(import(SMALL, &options), Err(ImportError::MaxSegment { found: 0.0 }));
}

#[test]
fn names_stay_unique_and_short() {
    let scenario =
        parsed(&with("<Id>B</Id>", "<Id>A</Id>").replace("<Id>left</Id>", &format!("<Id>{}</Id>", "long/".repeat(20))));
    assert_eq!(scenario["branches"][1]["from"].as_str(), Some("A-2"));
    assert_eq!(scenario["branches"][1]["name"].as_str(), Some("s2"));
}

/// Every broken form of the file is refused or imported into TOML with finite numbers; none panics.
#[test]
fn no_mutation_panics() {
    let snippets = ["<Segment id=\"x\"/>", "</Node>"];
    let [accepted, refused] = mutated(SMALL, 20_240_611, &snippets, |text| import(text, &Options::default()));
    assert!(accepted > 200 && refused > 1000, "{accepted} accepted, {refused} refused");
}

/// It was left out without a word, with what sits at it.
#[test]
fn a_node_at_which_no_segment_ends_is_told() {
    let lone = "<Node id=\"lone\"><Id>L</Id><Cartesian_point>p1</Cartesian_point></Node>\n  <Harness";
    let findings = imported(&with("<Harness", lone)).findings;
    let told = findings.iter().find(|own| own.what == "no segment ends at a node; left out");
    assert_eq!(told.map(|own| own.items.clone()), Some(vec!["lone".to_owned()]), "{findings:?}");
    assert!(imported(SMALL).findings.iter().all(|own| !own.what.contains("no segment ends")));
}

//! Times grow linearly with the size of the input, not with its square: checks, faults, imports, reports.

use std::fmt::Write;
use wireloom::export::report::{Points, write_points};
use wireloom::export::table::{Column, Table};
use wireloom::import::kbl::{Arrangement, Options, import};
use wireloom::import::vec;
use wireloom_tests::growth::no_square;

const SECTION: &str = "schema = 1\n[sections.s]\ndiameter = \"8 mm\"\nlinear_density = 0.12\naxial_stiffness = 2e4\n\
                       bending_stiffness = 0.012\ntorsion_stiffness = 0.009\n";

/// A chain of so many branches, of which every second joint has a stub; held at its beginning and along every branch.
fn chain(n: usize) -> String {
    let mut text = SECTION.to_owned();
    let mut branch = |name: &str, from: &str, to: &str| {
        let _ = write!(
            text,
            "[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"s\"\nlength = 0.1\n\
             segments = 2\n"
        );
    };
    for k in 0..n {
        branch(&format!("b{k}"), &format!("v{k}"), &format!("v{}", k + 1));
        if k % 2 == 1 {
            branch(&format!("stub{k}"), &format!("v{k}"), &format!("end{k}"));
        }
    }
    for k in 1..n {
        let stub = format!("  {{ branch = \"stub{k}\", direction = [0, 1, 0], up = [0, 0, 1] }},\n");
        let _ = write!(
            text,
            "[[joints]]\nname = \"v{k}\"\narms = [\n  {{ branch = \"b{}\", direction = [-1, 0, 0], up = [0, 0, 1] \
             }},\n  \
             {{ branch = \"b{k}\", direction = [1, 0, 0], up = [0, 0, 1] }},\n{}]\n",
            k - 1,
            if k % 2 == 1 { &stub } else { "" }
        );
    }
    for k in 0..n {
        let _ = write!(
            text,
            "[[constraints]]\nname = \"c{k}\"\nkind = \"collar\"\nat = {{ branch = \"b{k}\", s = 0.05 }}\n\
             position = [{}, 0, 0]\n\
             tangent = [1, 0, 0]\n",
            0.1 * k as f64
        );
    }
    text + "[[constraints]]\nname = \"plug\"\nkind = \"connector\"\nat = { end = \"v0\" }\n"
}

#[test]
fn checking_a_large_scenario_takes_no_square_of_its_size() {
    let registry = wireloom::registry();
    no_square("check of branches", 500, chain, |text| {
        assert!(wireloom::load(text, &registry).is_ok());
    });
}

#[test]
fn finding_many_faults_takes_no_square_of_their_number() {
    let registry = wireloom::registry();
    let faulty = |n: usize| {
        let with = |text: String, k: usize| {
            text + &format!(
                "[[loads]]\nname = \"l{k}\"\nat = {{ branch = \"none{k}\", s = {k} }}\nforce = 3\nforse = 1e400\n"
            )
        };
        (0..n).fold(chain(4), with)
    };
    no_square("faults", 1000, faulty, |text| {
        let faults = wireloom::load(text, &registry).err().unwrap_or_default();
        assert!(faults.len() > 1000);
        assert!(wireloom::scenario::render(text, &faults).len() > 1000);
    });
}

/// So many segments in a row, each with a wire of its own and one through all, clips, assemblies with a clip in each,
/// and nodes and constraints of one and the same name.
fn kbl(n: usize) -> String {
    let mut text = String::from(
        "<KBL_container><Unit id=\"mm\"><Si_unit_name>metre</Si_unit_name><Si_prefix>milli</Si_prefix></Unit>\
         <Unit id=\"mm2\"><Si_unit_name>metre</Si_unit_name><Si_prefix>milli</Si_prefix>\
         <Si_dimension>square</Si_dimension></Unit>",
    );
    let value = |name: &str, unit: &str, value: f64| {
        format!("<{name}><Unit_component>{unit}</Unit_component><Value_component>{value}</Value_component></{name}>")
    };
    for k in 0..=n {
        let _ = write!(
            text,
            "<Cartesian_point id=\"p{k}\"><Coordinates>{}</Coordinates><Coordinates>0</Coordinates>\
             <Coordinates>0</Coordinates></Cartesian_point>\
             <Node id=\"n{k}\"><Id>same</Id><Referenced_components>lost{k}</Referenced_components>\
             <Cartesian_point>p{k}</Cartesian_point></Node>",
            100 * k
        );
    }
    for k in 0..n {
        let _ = write!(
            text,
            "<Segment id=\"s{k}\"><Id>same</Id>{}<Fixing_assignment \
             id=\"f{k}\"><Location>0.5</Location><Fixing>none</Fixing></Fixing_assignment>\
             <Start_node>n{k}</Start_node><End_node>n{}</End_node></Segment>",
            value("Virtual_length", "mm", 100.0),
            k + 1
        );
        let _ = write!(
            text,
            "<Routing id=\"r{k}\"><Routed_wire>core{k}</Routed_wire><Segments>s{k}</Segments></Routing>\
             <Routing id=\"q{k}\"><Routed_wire>lost{k}</Routed_wire></Routing>"
        );
    }
    for k in 0..n {
        let _ = write!(
            text,
            "<Assembly_part id=\"a{k}\"><Fixing_occurrence id=\"i{k}\"><Part>none</Part></Fixing_occurrence>\
             </Assembly_part>"
        );
    }
    // One cable of very many cores.
    text += "<General_wire id=\"cable\">";
    for k in 0..n {
        let _ = write!(text, "<Core id=\"c{k}\">{}</Core>", value("Cross_section_area", "mm2", 0.5));
    }
    text += "</General_wire><Harness>";
    for k in 0..n {
        let _ = write!(
            text,
            "<Assembly_part_occurrence id=\"o{k}\"><Id>same</Id><Part>a{k}</Part></Assembly_part_occurrence>\
             <General_wire_occurrence id=\"w{k}\"><Core_occurrence \
             id=\"core{k}\"><Part>c{k}</Part></Core_occurrence></General_wire_occurrence>"
        );
    }
    text + "</Harness></KBL_container>"
}

#[test]
fn importing_a_large_harness_takes_no_square_of_its_size() {
    for arrangement in [Arrangement::Installed, Arrangement::Board, Arrangement::Assembly] {
        // As segments long as a branch: what takes time here is the file, not the mesh. On the board the turning of
        // subtrees is left out.
        let options = Options { max_segment: 0.1, arrangement, ..Options::default() };
        let n = if arrangement == Arrangement::Installed { 1000 } else { 4500 };
        no_square(&format!("import, {arrangement:?}"), n, kbl, |text| {
            assert!(import(text, &options).is_ok_and(|imported| imported.scenario.len() > 100_000));
        });
    }
}

/// So many segments in a row without geometry, each with a wire of its own, a clip and a covering, and one cable of
/// very many cores.
fn vec_file(n: usize) -> String {
    let value = |name: &str, unit: &str, value: f64| {
        format!("<{name}><UnitComponent>{unit}</UnitComponent><ValueComponent>{value}</ValueComponent></{name}>")
    };
    let mut text = String::from(
        "<VecContent xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"><DocumentVersion>\
         <Specification xsi:type=\"TopologySpecification\">",
    );
    for k in 0..=n {
        let _ = write!(text, "<TopologyNode id=\"n{k}\"><Identification>same</Identification></TopologyNode>");
    }
    for k in 0..n {
        let length = value("Length", "mm", 100.0);
        let _ = write!(
            text,
            "<TopologySegment id=\"s{k}\"><Identification>same</Identification><EndNode>n{}</EndNode>\
             <StartNode>n{k}</StartNode><LengthInformation>{length}<Classification>Designed</Classification>\
             </LengthInformation></TopologySegment>",
            k + 1
        );
    }
    text += "</Specification><Specification xsi:type=\"CompositionSpecification\">";
    for k in 0..n {
        let _ = write!(
            text,
            "<Component id=\"o{k}\"><Role xsi:type=\"WireRole\" id=\"o{k}r\"><WireSpecification>cable\
             </WireSpecification><WireElementReference id=\"w{k}\"><ReferencedWireElement>c{k}\
             </ReferencedWireElement></WireElementReference></Role></Component>\
             <Component id=\"f{k}\"><Role xsi:type=\"FixingRole\" id=\"f{k}r\"><FixingSpecification>none\
             </FixingSpecification></Role></Component>\
             <Component id=\"t{k}\"><Role xsi:type=\"TapeRole\" id=\"t{k}r\"><WireProtectionSpecification>tape\
             </WireProtectionSpecification></Role></Component>"
        );
    }
    text += "</Specification><Specification xsi:type=\"RoutingSpecification\">";
    for k in 0..n {
        let path = format!("<Path id=\"q{k}p\"><Segment>s{k}</Segment></Path>");
        let _ = write!(text, "<Routing id=\"q{k}\"><RoutedElement>w{k}</RoutedElement>{path}</Routing>");
    }
    text += "</Specification><Specification xsi:type=\"PlacementSpecification\">";
    for k in 0..n {
        let offset = value("Offset", "mm", 50.0);
        let at = format!("{offset}<Anchor>FromEndNode</Anchor><ReferencedSegment>s{k}</ReferencedSegment>");
        let node = |tag: &str, node: usize| {
            format!("<{tag} xsi:type=\"NodeLocation\"><ReferencedNode>n{node}</ReferencedNode></{tag}>")
        };
        let _ = write!(
            text,
            "<Placement xsi:type=\"OnPointPlacement\" id=\"fp{k}\"><PlacedElement>f{k}</PlacedElement>\
             <Location xsi:type=\"SegmentLocation\">{at}</Location></Placement>\
             <Placement xsi:type=\"OnWayPlacement\" id=\"tp{k}\"><PlacedElement>t{k}</PlacedElement>\
             {}{}</Placement>",
            node("EndLocation", k + 1),
            node("StartLocation", k)
        );
    }
    text += "</Specification><Specification xsi:type=\"TapeSpecification\" id=\"tape\"></Specification>\
             <Specification xsi:type=\"WireSpecification\" id=\"cable\"><WireElement id=\"all\">";
    for k in 0..n {
        let _ = write!(
            text,
            "<SubWireElement id=\"c{k}\"><WireElementSpecification>core</WireElementSpecification></SubWireElement>"
        );
    }
    text += "</WireElement></Specification>\
             <Specification xsi:type=\"WireElementSpecification\" id=\"core\"></Specification></DocumentVersion>";
    text + "<Unit xsi:type=\"SIUnit\" id=\"mm\"><SiUnitName>Metre</SiUnitName><SiPrefix>Milli</SiPrefix></Unit>\
            </VecContent>"
}

#[test]
fn importing_a_large_vec_file_takes_no_square_of_its_size() {
    let options = Options { max_segment: 0.1, arrangement: Arrangement::Board, ..Options::default() };
    no_square("import of VEC", 2000, vec_file, |text| {
        assert!(vec::import(text, &options).is_ok_and(|imported| imported.scenario.len() > 100_000));
    });
}

#[test]
fn a_report_on_very_many_points_takes_no_square_of_their_number() {
    let table = |rows: usize| {
        let column = |f: &dyn Fn(usize) -> f64| Column::Numbers((0..rows).map(|k| Some(f(k))).collect());
        let words = Column::Words(vec![Some("converged".to_owned()); rows]);
        let columns = vec![
            ("point".to_owned(), column(&|k| k as f64)),
            ("length".to_owned(), column(&|k| (k % 97) as f64)),
            ("stiffness".to_owned(), column(&|k| (k % 89) as f64)),
            ("status".to_owned(), words),
            ("min_bend_radius".to_owned(), column(&|k| (k % 97) as f64 + 0.1 * (k % 7) as f64)),
            ("max_force".to_owned(), column(&|k| (k % 83) as f64)),
        ];
        Table { columns, notes: Vec::new() }
    };
    no_square("report", 5000, table, |table| {
        let mut page = Vec::new();
        write_points(&Points { title: "t", table, file: "s.toml", program: "p", written: "w" }, &mut page)
            .expect("bytes");
        assert!(String::from_utf8_lossy(&page).contains("By the least-squares plane through all points"));
    });
}

//! Small VEC files of our own: the same harness as `small.kbl`, and what only VEC has.

mod common;
#[path = "common/mutated.rs"]
mod mutations;

use common::checked;
use mutations::mutated;
use wireloom_core::identity::{Identities, WireEnd};
use wireloom_import::kbl;
use wireloom_import::kbl::{Arrangement, Contents, Imported, Options, Selection};
use wireloom_import::vec::{contents, import};

const KBL: &str = include_str!("small.kbl");
const VEC_1_2: &str = include_str!("small-1.2.vec");
const VEC_2_1: &str = include_str!("small.vec");

fn imported(text: &str) -> Imported {
    import(text, &Options::default()).unwrap()
}

fn parsed(text: &str) -> toml::Table {
    toml::from_str(&imported(text).scenario).unwrap()
}

fn refused(text: &str) -> String {
    import(text, &Options::default()).unwrap_err().to_string()
}

fn findings(text: &str) -> Vec<String> {
    imported(text).findings.iter().map(ToString::to_string).collect()
}

fn with(old: &str, new: &str) -> String {
    assert!(VEC_2_1.contains(old), "{old}");
    VEC_2_1.replacen(old, new, 1)
}

/// Line and column of the first occurrence, from 1, as messages give them.
fn place(text: &str, what: &str) -> String {
    let before = &text[..text.find(what).unwrap()];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    format!("{}:{}", before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// The KBL file with the part numbers that VEC cannot do without.
fn numbered() -> String {
    let part = |text: &str, element: &str, number: &str| {
        let numbers = format!("{element}<Part_number>{number}</Part_number><Company_name>ACME</Company_name>");
        assert!(text.contains(element), "{element}");
        text.replacen(element, &numbers, 1)
    };
    let text = part(KBL, "<General_wire id=\"part1\">", "W 1");
    let text = part(&text, "<General_wire id=\"cable\">", "W 2");
    part(&text, "<Wire_protection id=\"tape\">", "V 1")
}

/// Lines of a scenario without the identities of the KBL file and without comments of their own.
fn lines(scenario: &str) -> Vec<&str> {
    let told = |line: &&str| !line.starts_with('#') && !line.starts_with("kbl = ");
    scenario.lines().filter(told).collect()
}

#[test]
fn the_same_harness_as_kbl_and_as_vec_gives_the_same_scenario() {
    for arrangement in [Arrangement::Installed, Arrangement::Board, Arrangement::Assembly] {
        let options = Options { arrangement, ..Options::default() };
        let of_kbl = kbl::import(&numbered(), &options).unwrap();
        for text in [VEC_1_2, VEC_2_1] {
            let of_vec = import(text, &options).unwrap();
            checked(&of_vec.scenario);
            let (ours, theirs) = (lines(&of_vec.scenario), lines(&of_kbl.scenario));
            for (ours, theirs) in ours.iter().zip(&theirs) {
                assert_eq!(ours, theirs, "{arrangement:?}");
            }
            assert_eq!((ours.len(), of_vec.wires), (theirs.len(), of_kbl.wires.clone()));
        }
    }
}

#[test]
fn the_version_is_identified_and_one_that_is_not_known_is_told() {
    for (text, version) in [(VEC_1_2, "1.2.0"), (VEC_2_1, "2.1.0")] {
        let Imported { scenario, findings, .. } = imported(text);
        assert!(scenario.starts_with(&format!("# Made from a VEC file (VDA 4968, {version}) by")), "{scenario}");
        assert!(!findings.iter().any(|finding| finding.what.contains("VecVersion")), "{findings:?}");
    }
    let other = with("<VecVersion>2.1.0<", "<VecVersion>3.0.0<");
    let known = "1.2.0, 1.2.1, 1.2.2, 2.0.0, 2.0.1, 2.0.2, 2.1.0, 2.2.0";
    let told =
        format!("4:3: VecVersion is `3.0.0`, which is not known (known: {known}); read as far as it is like these");
    assert!(findings(&other).contains(&told), "{:#?}", findings(&other));
    let none = findings(&with("  <VecVersion>2.1.0</VecVersion>\n", ""));
    assert!(none.iter().any(|finding| finding.starts_with("3:1: VecContent has no VecVersion")), "{none:#?}");
    let foreign = findings(&with("http://www.prostep.org/ecad-if/2011/vec", "urn:other"));
    assert!(
        foreign.iter().any(|finding| finding.contains("the namespace of VecContent is `urn:other`")),
        "{foreign:#?}"
    );
}

#[test]
fn refusals_name_place_and_cure() {
    let broken = with("</Unit>", "</Unt>");
    assert!(refused(&broken).starts_with(&format!("{}: not well-formed XML", place(&broken, "</Unt>"))));
    let what = "the root element is `KBL_container`; a VEC file has `VecContent` there; \
                `wireloom import kbl` reads KBL files";
    assert_eq!(refused(KBL), format!("{}: {what}", place(KBL, "<kbl:KBL_container")));
    let what = "the root element is `VecContent`; a KBL file has `KBL_container` there; \
                `wireloom import vec` reads VEC files";
    let given = kbl::import(VEC_2_1, &Options::default()).unwrap_err().to_string();
    assert_eq!(given, format!("{}: {what}", place(VEC_2_1, "<vec:VecContent")));
    assert_eq!(refused("<svg/>"), "1:1: the root element is `svg`; a VEC file has `VecContent` there");
    assert!(refused("<VecContent/>").contains("the file has no `TopologySegment`"));

    let cases = [
        ("<StartNode>n3</StartNode>", "<StartNode>nowhere</StartNode>", "`nowhere` is not the id of a `TopologyNode`"),
        ("<BaseUnit>uMM</BaseUnit>", "<BaseUnit>uGM</BaseUnit>", "it is that of a unit of mass per length"),
        ("<BaseUnit>uMM</BaseUnit>", "<BaseUnit>none</BaseUnit>", "`none` is not the id of a `unit of length`"),
        ("<X>150</X>", "<X>15o</X>", "`15o` in `X` is not a finite decimal number"),
        ("<ReferenceNode>n4</ReferenceNode>", "", "TopologyNode `n4` has no `GeometryNode3D`"),
        ("<Origin>pClip</Origin>", "<Origin>clip</Origin>", "(it is that of a `Component`)"),
        ("<Knots>1</Knots>", "<Knots>one</Knots>", "`one` in `Knots` is not a finite decimal number"),
    ];
    for (old, new, what) in cases {
        let said = refused(&with(old, new));
        assert!(said.contains(what) && said.starts_with(|c: char| c.is_ascii_digit()), "{said}");
    }
    let broken = with("<StartNode>n3</StartNode>", "");
    let what = "TopologySegment `s2` has no `StartNode`; a segment runs from one node to another";
    assert_eq!(refused(&broken), format!("{}: {what}", place(&broken, "<TopologySegment id=\"s2\"")));
}

#[test]
fn what_a_harness_can_do_without_is_a_finding() {
    let found = |text: &str, what: &str| {
        let findings = findings(text);
        assert!(findings.iter().any(|finding| finding.contains(what)), "{what}: {findings:#?}");
    };
    let missing = with("<Length id=\"l3\"><UnitComponent>uMM</UnitComponent>", "<Length id=\"l3\">");
    let (line, _) =
        place(&missing, "<Length id=\"l3\">").split_once(':').map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
    found(&missing, &format!("Length is 250 of the unknown unit `` (line {line})"));
    found(&missing, "no usable one of the class Designed or a length of the class Adapted");
    found(&with("<RoutedElement>w1<", "<RoutedElement>nobody<"), "`nobody` is not the id of a `WireElementReference`");
    found(&with("<PlacedElement>plugA-place<", "<PlacedElement>ghost<"), "`ghost` is not the id of");
    found(&with("<PlacedElement>plugA-place<", "<PlacedElement>ghost<"), "connectors sit at no node; left out");
    found(&with("<CartesianPoint3D>pA1<", "<CartesianPoint3D>gone<"), "`gone` is not the id of a `CartesianPoint`");
    found(&with("<Knots>0</Knots><Knots>0</Knots>", "<Knots>0</Knots>"), "curves without usable knots");
    found(&with("<Anchor>FromStartNode</Anchor>", ""), "places without a usable Anchor; counted from the start");
    found(&with("<Classification>Adapted<", "<Classification>Guessed<"), "neither Designed nor Adapted; not used: s2");
    found(&with("<Segment>s1 s2</Segment>", "<Segment>s1 s9</Segment>"), "runs through segment `s9`");
    found(&with("<ValueComponent>155<", "<ValueComponent>255<"), "tape1 (255.0 mm, places 154.0 mm)");
    found(
        &with("xsi:type=\"vec:NURBSCurve\"", "xsi:type=\"vec:Spiral\""),
        "Spiral `k1`: curves of this class are not known",
    );
}

/// A row of the table of an import, which counts every element once.
fn row(imported: &Imported, kind: &str) -> [usize; 4] {
    let own =
        imported.usage.iter().find(|own| own.kind == kind).unwrap_or_else(|| panic!("{kind}: {:?}", imported.usage));
    assert_eq!(own.total, own.used + own.kept + own.left_out + own.not_read, "{own:?}");
    [own.used, own.kept, own.left_out, own.not_read]
}

#[test]
fn an_import_says_what_became_of_each_element() {
    let more = "  <DocumentVersion id=\"doc-more\"><CompanyName>ACME</CompanyName><DocumentNumber>9</DocumentNumber>\
                <DocumentVersion>1</DocumentVersion>\
                <Specification xsi:type=\"vec:FerriteSpecification\" id=\"ferrite\"><Identification>f\
                </Identification></Specification></DocumentVersion>\n  <PartVersion id=\"harness\">";
    let imported = imported(&with("  <PartVersion id=\"harness\">", more));
    let expected = [
        ("BuildingBlockPositionings", [1, 0, 0, 0]),
        ("CartesianPoint", [7, 0, 0, 0]),
        // Plugs A and B, the clip, the tape and the wires act; the splice does not.
        ("Component", [8, 1, 0, 0]),
        ("CoreSpecification", [2, 0, 0, 0]),
        ("GeometryNode", [5, 0, 0, 0]),
        ("GeometrySegment", [4, 0, 0, 0]),
        ("OnPointPlacement", [4, 0, 0, 0]),
        ("PartVersion", [0, 4, 0, 0]),
        ("Routing", [4, 0, 0, 0]),
        ("TapeSpecification", [1, 0, 0, 0]),
        ("TopologySegment", [4, 0, 0, 0]),
        ("FerriteSpecification", [0, 0, 0, 1]),
    ];
    for (kind, expected) in expected {
        assert_eq!(row(&imported, kind), expected, "{kind}: {:#?}", imported.usage);
    }
    let said: Vec<String> = imported.findings.iter().map(ToString::to_string).collect();
    assert!(
        said.iter()
            .any(|line| line.starts_with("elements that are not read") && line.contains("1 FerriteSpecification"))
    );
    assert!(said.iter().any(|line| line.starts_with("parts of elements that are not read")), "{said:#?}");
    assert!(imported.scenario.contains("# - 1 FerriteSpecification: 0 used, 0 named, 0 of other modules, 1 not read"));
}

/// Tolerances stand in the values; a dimension between the nodes of a segment and a default give them to others.
#[test]
fn tolerances_of_values_are_a_sweep_in_comments() {
    let own = "<ValueComponent>307.9</ValueComponent><Tolerance id=\"t1\"><LowerBoundary>-1</LowerBoundary>\
               <UpperBoundary>10</UpperBoundary></Tolerance>";
    let dimension = "<Dimension id=\"dim\"><Identification>d</Identification><DimensionAnchor>p2-at</DimensionAnchor>\
                     <ReferenceAnchor>dim-at</ReferenceAnchor><UnitComponent>uM</UnitComponent>\
                     <DefinedLocations xsi:type=\"vec:NodeLocation\" id=\"dim-at\"><Identification>J</Identification>\
                     <ReferencedNode>n2</ReferencedNode></DefinedLocations><Tolerance id=\"t2\">\
                     <LowerBoundary>0</LowerBoundary><UpperBoundary>0.005</UpperBoundary></Tolerance>\
                     </Dimension>\n      \
                     <Placement xsi:type=\"vec:OnPointPlacement\" id=\"p1\">";
    let default = "<Specification xsi:type=\"vec:DefaultDimensionSpecification\" id=\"dd\"><Identification>dd\
                   </Identification><DefaultDimension id=\"dd1\"><DimensionValueRange id=\"dd1-r\"><UnitComponent>uMM\
                   </UnitComponent><Minimum>0</Minimum><Maximum>100</Maximum></DimensionValueRange>\
                   <DimensionType>SegmentLengths</DimensionType><ToleranceIndication id=\"t3\">\
                   <LowerBoundary>-2</LowerBoundary><UpperBoundary>3</UpperBoundary></ToleranceIndication>\
                   </DefaultDimension></Specification>\n    <Specification xsi:type=\"vec:RoutingSpecification\"";
    let text = with("<ValueComponent>307.9</ValueComponent>", own)
        .replacen("<Placement xsi:type=\"vec:OnPointPlacement\" id=\"p1\">", dimension, 1)
        .replacen("<Specification xsi:type=\"vec:RoutingSpecification\"", default, 1);
    let scenario = imported(&text).scenario;
    let begin = scenario.find("# [sweep]").expect("a sweep");
    let end = scenario.find("# End of the sweep.").expect("its end");
    let sweep: String = scenario[begin..end].lines().map(|line| format!("{}\n", &line[2..])).collect();
    let sweep: toml::Table = toml::from_str(&sweep).unwrap();
    let varied = sweep["sweep"]["vary"].as_table().unwrap();
    let expected = [("trunk", 0.3069, 0.3179), ("left", 0.26, 0.265), ("stub", 0.028, 0.033)];
    assert_eq!(varied.len(), expected.len(), "{varied:?}");
    for (branch, from, to) in expected {
        let range = &varied[&format!("branches.{branch}.length")];
        for (key, expected) in [("from", from), ("to", to)] {
            assert!((range[key].as_float().unwrap() - expected).abs() < 1e-9, "{branch} {range:?}");
        }
    }
}

/// Static radii are those of the parts at rest, dynamic ones those of what moves; ways have their own.
#[test]
fn bend_radii_are_static_and_dynamic() {
    let radius = |id: &str, name: &str, value: f64| {
        format!(
            "<{name} id=\"{id}\"><UnitComponent>uMM</UnitComponent><ValueComponent>{value}</ValueComponent></{name}>"
        )
    };
    let both = radius("rd", "MinBendRadiusDynamic", 16.0) + "<MinBendRadiusStatic id=\"r2\">";
    let restricted = format!(
        "<Specification xsi:type=\"vec:TopologyBendingRestrictionSpecification\" id=\"tb\"><Identification>tb\
         </Identification><TopologyBendingRestriction id=\"tb1\">{}{}<RestrictedPath id=\"tb1-p\">\
         <Segment>s3 s4</Segment></RestrictedPath></TopologyBendingRestriction></Specification>\n    \
         <Specification xsi:type=\"vec:RoutingSpecification\"",
        radius("tbd", "MinBendRadiusDynamic", 40.0),
        radius("tbs", "MinBendRadiusStatic", 32.5)
    );
    let text = with("<MinBendRadiusStatic id=\"r2\">", &both).replacen(
        "<Specification xsi:type=\"vec:RoutingSpecification\"",
        &restricted,
        1,
    );
    let scenario = checked(&imported(&text).scenario);
    let radii = |i: usize| {
        let section = &scenario.sections[scenario.branches[i].section];
        [section.min_bend_radius, section.min_bend_radius_moving].map(|r| r.map(|r| (r * 1e7).round() * 1e-4))
    };
    // The trunk has a core with both; the left arm thin wires alone; the right one a core, and the stub is narrow.
    assert_eq!(radii(0)[1], Some(16.0));
    assert_eq!(radii(1)[1], None);
    assert_eq!((radii(2), radii(3)), ([Some(32.5), Some(40.0)], [Some(32.5), Some(40.0)]));
    let moving = with("MinBendRadiusStatic id=\"r2\"", "MinBendRadiusDynamic id=\"r2\"").replacen(
        "8</ValueComponent></MinBendRadiusStatic>",
        "8</ValueComponent></MinBendRadiusDynamic>",
        1,
    );
    let told = findings(&moving);
    assert!(told.iter().any(|finding| finding.starts_with("wires with a dynamic bend radius alone")), "{told:#?}");
}

/// Parts that hold the cable are known by their roles, however they are mounted; a grommet lets it slide, a tie holds
/// nothing.
#[test]
fn fixings_hold_by_their_kind() {
    let kind = |specification: &str, role: &str, reference: &str| {
        let text = with("vec:HoleMountedFixingSpecification", &format!("vec:{specification}"))
            .replacen("vec:HoleMountedFixingRole", &format!("vec:{role}"), 1)
            .replacen(
                "<FixingSpecification>hole-fixing</FixingSpecification>",
                &format!("<{reference}>hole-fixing</{reference}>"),
                1,
            );
        let scenario = parsed(&text);
        let clips = scenario["constraints"].as_array().unwrap();
        let clip = clips.iter().find(|own| own["name"].as_str() == Some("clip-1"));
        (clip.map(|own| own.get("rail").is_some()), text)
    };
    for mount in ["Hole", "Edge", "Bolt"] {
        let (slides, _) = kind(
            &format!("{mount}MountedFixingSpecification"),
            &format!("{mount}MountedFixingRole"),
            "FixingSpecification",
        );
        assert_eq!(slides, Some(false), "{mount}");
    }
    assert_eq!(kind("GrommetSpecification", "GrommetRole", "GrommetSpecification").0, Some(true));
    assert_eq!(kind("CableDuctSpecification", "CableDuctRole", "CableDuctSpecification").0, Some(true));
    let (tie, text) = kind("CableTieSpecification", "CableTieRole", "CableTieSpecification");
    assert_eq!(tie, None);
    let told = findings(&text);
    assert!(told.iter().any(|own| own.contains("they hold nothing there: clip `clip-1` (cable tie)")), "{told:#?}");
    let scenario = imported(&text).scenario;
    assert!(scenario.contains("kind = \"cable tie\"\nbranch = \"trunk\""), "{scenario}");
}

/// A covering over several segments covers each between its ends, with or without the way; what has no way is told.
#[test]
fn coverings_lie_over_ways() {
    let location = |tag: &str, node: &str| {
        format!(
            "<{tag} xsi:type=\"vec:NodeLocation\" id=\"over-{tag}\"><Identification>x</Identification>\
                 <ReferencedNode>{node}</ReferencedNode></{tag}>"
        )
    };
    let over = |path: &str| {
        let begin = VEC_2_1.find("<EndLocation").unwrap();
        let end = VEC_2_1.find("<StartLocation").unwrap();
        let rest = VEC_2_1[end..].find("</StartLocation>").unwrap() + end + "</StartLocation>".len();
        let own = location("EndLocation", "n4") + path + &location("StartLocation", "n3");
        [&VEC_2_1[..begin], &own, &VEC_2_1[rest..]].concat()
    };
    for path in ["", "<Path id=\"w\"><Segment>s2 s3</Segment></Path>"] {
        let components = checked(&imported(&over(path)).scenario).identities.components;
        let tape: Vec<_> = components.iter().filter(|own| own.kind.as_deref() == Some("wire protection")).collect();
        let at: Vec<_> = tape.iter().map(|own| (own.branch.as_deref(), own.from, own.to)).collect();
        assert_eq!(at, [(Some("left"), Some(0.0), Some(0.26)), (Some("right"), Some(0.0), Some(0.25))]);
    }
    let told = findings(&over("<Path id=\"w\"><Segment>s2 s4</Segment></Path>"));
    assert!(told.iter().any(|own| own.starts_with("no way through the segments") && own.contains("pa1")), "{told:#?}");
}

/// A rational curve of degree 2 with knots of its own is an arc of a circle.
#[test]
fn a_rational_curve_is_an_arc() {
    // From A over 150 mm above the chord to J: a half circle of radius 150 mm, as two quarters.
    let begin = VEC_2_1.find("<Curve xsi:type=\"vec:NURBSCurve\" id=\"k1\">").unwrap();
    let end = VEC_2_1[begin..].find("</Curve>").unwrap() + begin;
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let control: String = [("pA", 1.0), ("b1", quarter), ("b2", 1.0), ("b3", quarter), ("pJ", 1.0)]
        .iter()
        .map(|(point, weight)| {
            let own = format!("<Weight>{weight}</Weight><CartesianPoint3D>{point}</CartesianPoint3D>");
            format!("<ControlPoint id=\"c-{point}\">{own}</ControlPoint>")
        })
        .collect();
    let knots: String = [0, 0, 0, 2, 2, 5, 5, 5].iter().map(|knot| format!("<Knots>{knot}</Knots>")).collect();
    let arc = format!("<Curve xsi:type=\"vec:NURBSCurve\" id=\"k1\"><Degree>2</Degree>{knots}{control}");
    let points = "<CartesianPoint id=\"b1\"><X>0</X><Y>150</Y><Z>0</Z></CartesianPoint>\
                  <CartesianPoint id=\"b2\"><X>150</X><Y>150</Y><Z>0</Z></CartesianPoint>\
                  <CartesianPoint id=\"b3\"><X>300</X><Y>150</Y><Z>0</Z></CartesianPoint><CartesianPoint id=\"pA\">";
    let text = [&VEC_2_1[..begin], &arc, &VEC_2_1[end..]].concat();
    let text = text.replacen("<CartesianPoint id=\"pA\">", points, 1).replacen(
        "<ValueComponent>307.9<",
        "<ValueComponent>471.24<",
        1,
    );
    let scenario = parsed(&text);
    let path = scenario["branches"][0]["path"].as_array().unwrap();
    assert!(path.len() > 40);
    for point in path {
        let [x, y]: [f64; 2] = std::array::from_fn(|k| point[k].as_float().unwrap());
        assert!(((x - 0.15).hypot(y) - 0.15).abs() < 1e-8, "{x} {y}");
    }
    assert!(!findings(&text).iter().any(|own| own.contains("as long as their drawn curves") && own.contains("s1")));
}

/// A building block lies where the geometry of the harness puts it, in its own unit.
#[test]
fn building_blocks_have_places_and_units() {
    let placed = with(
        "<Referenced3DBuildingBlock>block</Referenced3DBuildingBlock>",
        "<Referenced3DBuildingBlock>block</Referenced3DBuildingBlock><Positioning id=\"tr\"><A11>0</A11><A12>-1</A12>\
         <A13>0</A13><A21>1</A21><A22>0</A22><A23>0</A23><A31>0</A31><A32>0</A32><A33>1</A33><Origin>pS</Origin>\
         </Positioning>",
    );
    let end = |text: &str| {
        let scenario = parsed(text);
        let path = scenario["branches"][0]["path"].as_array().unwrap().clone();
        let last: Vec<f64> = path.last().unwrap().as_array().unwrap().iter().map(|x| x.as_float().unwrap()).collect();
        last
    };
    assert_eq!(end(VEC_2_1), [0.3, 0.0, 0.0]);
    assert_eq!(end(&placed), [0.3, 0.3, 0.03]);
    let inches = "<BaseUnit>uInch</BaseUnit>";
    let text = with("<BaseUnit>uMM</BaseUnit>", inches).replacen(
        "  <Unit xsi:type=\"vec:SIUnit\" id=\"uM\">",
        "  <Unit xsi:type=\"vec:ImperialUnit\" id=\"uInch\"><ImperialUnitName>Inch</ImperialUnitName></Unit>\n  \
         <Unit xsi:type=\"vec:SIUnit\" id=\"uM\">",
        1,
    );
    assert!((end(&text)[0] - 300.0 * 0.0254).abs() < 1e-9);
    let board = with("<Type>Dmu</Type>", "<Type>Formboard</Type>");
    assert!(refused(&board).contains("the file has no 3D geometry (GeometryNode3D)"), "{}", refused(&board));
}

/// A file with lengths alone lies on a board; in a vehicle it has no place.
#[test]
fn without_geometry_a_harness_lies_on_a_board() {
    let begin = VEC_2_1.find("    <Specification xsi:type=\"vec:BuildingBlockSpecification3D\"").unwrap();
    let end = VEC_2_1.find("    <Specification xsi:type=\"vec:CompositionSpecification\"").unwrap();
    let flat = [&VEC_2_1[..begin], &VEC_2_1[end..]].concat();
    let what = "the file has no 3D geometry (GeometryNode3D), and does not say where its segments lie; as a harness on \
                a board (--as board) their lengths are enough";
    assert_eq!(refused(&flat), format!("{}: {what}", place(&flat, "<TopologySegment id=\"s1\"")));
    let options = Options { arrangement: Arrangement::Board, ..Options::default() };
    let scenario = checked(&import(&flat, &options).unwrap().scenario);
    let said: Vec<String> = import(&flat, &options).unwrap().findings.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|own| own.starts_with("the file has no 3D geometry")), "{said:#?}");
    assert!(!said.iter().any(|own| own.contains("centre curve") || own.contains("drawn apart")), "{said:#?}");
    let lengths: Vec<f64> = scenario.branches.iter().map(|own| own.length).collect();
    assert_eq!(lengths, [0.3079, 0.26, 0.25, 0.03]);
    let begin = flat.find("<LengthInformation id=\"l3-i\">").unwrap();
    let end = flat[begin..].find("</LengthInformation>").unwrap() + begin + "</LengthInformation>".len();
    let bare = [&flat[..begin], &flat[end..]].concat();
    let said = import(&bare, &options).unwrap_err().to_string();
    assert!(said.contains("TopologySegment `s3` has no `LengthInformation`"), "{said}");
}

/// Two modules, of which each has wires of its own, a variant of one of them, and one of parts.
fn modular() -> String {
    let structure = |id: &str, content: &str| {
        format!(
            "<Specification xsi:type=\"vec:PartStructureSpecification\" id=\"{id}\"><Identification>{id}\
                 </Identification><Content>{content}</Content></Specification>\n    "
        )
    };
    let occurrence = |id: &str, of: &str, parts: &str| {
        format!(
            "<Component id=\"{id}\"><Identification>{id}</Identification><Role xsi:type=\
                 \"vec:PartWithSubComponentsRole\" id=\"{id}-role\"><PartStructureSpecification>{of}\
                 </PartStructureSpecification><SubComponent>{parts}</SubComponent></Role></Component>\n      "
        )
    };
    let structures = structure("module", "Module") + &structure("variant", "Variant");
    let occurrences = [
        occurrence("left", "module", "o1 o4 plugB spliceS"),
        occurrence("right", "module", "o2 wc clip tape1"),
        occurrence("plain", "variant", "right"),
        occurrence("whole", "variant", "left right-role plugA"),
    ]
    .concat();
    let composition = "<Specification xsi:type=\"vec:CompositionSpecification\"";
    with(composition, &(structures + composition)).replacen(
        "<Component id=\"plugA\">",
        &(occurrences + "<Component id=\"plugA\">"),
        1,
    )
}

#[test]
fn modules_and_variants_leave_parts_out() {
    let text = modular();
    let Contents { modules, variants } = contents(&text).unwrap();
    let listed: Vec<_> = modules.iter().map(|own| (own.name.as_str(), own.parts)).collect();
    assert_eq!(listed, [("left", 4), ("right", 4)]);
    let listed: Vec<_> = variants.iter().map(|own| (own.name.as_str(), own.modules.join(" "))).collect();
    assert_eq!(listed, [("plain", "right".to_owned()), ("whole", "left right".to_owned())]);
    let names = |selection: Selection, key: &str| -> Vec<String> {
        let imported = import(&text, &Options { selection, ..Options::default() }).unwrap();
        let scenario: toml::Table = toml::from_str(&imported.scenario).unwrap();
        scenario[key].as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap().to_owned()).collect()
    };
    let plain = || Selection::Variant("plain".to_owned());
    assert_eq!(names(plain(), "branches"), ["trunk", "right"]);
    // Plug A belongs to another variant.
    assert_eq!(names(plain(), "constraints")[0], "clip-1");
    let left = || Selection::Modules(vec!["left".to_owned()]);
    assert_eq!(names(left(), "branches"), ["trunk", "left", "stub"]);
    assert_eq!(names(left(), "constraints"), ["plug A", "plug B"]);
    assert_eq!(names(Selection::All, "branches").len(), 4);
    let imported = import(&text, &Options { selection: left(), ..Options::default() }).unwrap();
    // One module, one variant and what they leave out.
    assert_eq!(row(&imported, "Routing"), [2, 0, 2, 0]);
    assert_eq!(row(&imported, "TopologySegment"), [3, 0, 1, 0]);
}

/// Signals, cavities, terminals and seals stay with the wires, part numbers with the parts.
#[test]
fn wires_know_what_they_connect() {
    let housing = "<Specification xsi:type=\"vec:ConnectorHousingSpecification\" id=\"housing\">\n      \
                   <Identification>housing</Identification>";
    let slot = format!(
        "{housing}<Slot xsi:type=\"vec:Slot\" id=\"slot\"><SlotNumber>A</SlotNumber><Cavity id=\"cavity\">\
         <CavityNumber>7</CavityNumber></Cavity></Slot>"
    );
    let equipped = "<ConnectorHousingSpecification>housing</ConnectorHousingSpecification><SlotReference \
                    xsi:type=\"vec:SlotReference\" id=\"slot-ref\"><ReferencedSlot>slot</ReferencedSlot>\
                    <CavityReference id=\"cavity-ref\"><ReferencedCavity>cavity</ReferencedCavity></CavityReference>\
                    </SlotReference></Role>";
    let terminal = "<Component id=\"t1\"><Identification>t1</Identification><Role \
                    xsi:type=\"vec:PluggableTerminalRole\" id=\"t1-role\"><TerminalSpecification>splice-terminal\
                    </TerminalSpecification></Role><Part>tape</Part></Component>\n      <Component id=\"o1\">";
    let contacts = "<Specification xsi:type=\"vec:ContactingSpecification\" id=\"contacts\"><Identification>c\
                    </Identification><ContactPoint id=\"cp\"><MountedTerminal>t1-role</MountedTerminal><CavityMounting \
                    id=\"cm\"><EquippedCavityRef>cavity-ref</EquippedCavityRef></CavityMounting>\
                    <WireMounting id=\"wm\"><ReferencedWireEnd>end</ReferencedWireEnd></WireMounting></ContactPoint>\
                    </Specification>\n    \
                    <Specification xsi:type=\"vec:SignalSpecification\" id=\"signals\"><Identification>s\
                    </Identification><Signal id=\"signal\"><Identification>1</Identification><SignalName>CAN-H\
                    </SignalName></Signal></Specification>\n    <Specification xsi:type=\"vec:RoutingSpecification\"";
    let wire = "<ReferencedWireElement>part1-1</ReferencedWireElement><Signal>signal</Signal><WireEnd id=\"end\">\
                <PositionOnWire>0</PositionOnWire></WireEnd></WireElementReference>";
    let text = with(housing, &slot)
        .replacen("<ConnectorHousingSpecification>housing</ConnectorHousingSpecification></Role>", equipped, 1)
        .replacen("<Component id=\"o1\">", terminal, 1)
        .replacen("<Specification xsi:type=\"vec:RoutingSpecification\"", contacts, 1)
        .replacen("<ReferencedWireElement>part1-1</ReferencedWireElement></WireElementReference>", wire, 1);
    let Identities { connections, .. } = checked(&imported(&text).scenario).identities;
    let line = &connections[0];
    let text = |text: &str| Some(text.to_owned());
    assert_eq!((line.name.as_str(), &line.signal, &line.identity.part), ("c1", &text("CAN-H"), &text("W 1")));
    let end = WireEnd { connector: text("plug A"), cavity: text("7"), terminal: text("V 1"), seal: None };
    assert_eq!(line.ends, [end]);
}

/// Small Y with the whole cable, both of its cores, and their routings in this order.
fn cabled(routed: &[&str]) -> String {
    let reference = |id: &str, element: &str| {
        format!(
            "<WireElementReference id=\"{id}\"><Identification>{id}</Identification><ReferencedWireElement>{element}\
             </ReferencedWireElement></WireElementReference>"
        )
    };
    let routing = |id: &&str| {
        format!(
            "<Routing id=\"q-{id}\"><RoutedElement>{id}</RoutedElement><Path id=\"q-{id}-way\"><Segment>s3 s1\
             </Segment></Path></Routing>"
        )
    };
    let begin = VEC_2_1.find("<Routing id=\"q3\">").unwrap();
    let end = VEC_2_1.find("<Routing id=\"q4\">").unwrap();
    let routings: String = routed.iter().map(routing).collect();
    let text = [&VEC_2_1[..begin], &routings, &VEC_2_1[end..]].concat();
    let first = "<WireElementReference id=\"w3\">";
    assert!(text.contains(first));
    let others = reference("w30", "cable-0") + &reference("w31", "core2");
    text.replacen(first, &(others + first), 1)
}

#[test]
fn a_cable_whose_cores_are_referred_to_as_well_does_not_count_twice() {
    for routed in [&["w3", "w31"][..], &["w30"], &["w30", "w3", "w31"], &["w3", "w31", "w30"], &["w31", "w30", "w3"]] {
        let Imported { scenario, findings, .. } = imported(&cabled(routed));
        assert!(scenario.contains("# 4 wires, 3.00 mm² copper"), "{routed:?} {scenario}");
        let untold = findings.iter().all(|own| !own.what.contains("no routing") && !own.what.contains("several ways"));
        assert!(untold, "{routed:?} {findings:#?}");
    }
}

#[test]
fn wires_without_a_routing_are_not_dropped_without_a_word() {
    let said = |text: &str| findings(text).into_iter().filter(|own| own.contains("no routing")).collect::<Vec<_>>();
    let without = |id: &str, text: &str| {
        let begin = text.find(&format!("<Routing id=\"{id}\">")).unwrap();
        let end = text[begin..].find("</Routing>").unwrap() + begin + "</Routing>".len();
        [&text[..begin], &text[end..]].concat()
    };
    let none: [&str; 0] = [];
    assert_eq!(said(VEC_2_1), none);
    assert_eq!(said(&without("q4", VEC_2_1)), ["wires have no routing; they are not counted: w4"]);
    // The whole cable needs no routing beside those of its cores, but the second core does.
    assert_eq!(said(&cabled(&["w3"])), ["wires have no routing; they are not counted: w31"]);
    // With a jacket the cable counts whole wherever one core runs.
    let jacket = "<OutsideDiameter id=\"d3\"><UnitComponent>uMM</UnitComponent><ValueComponent>5</ValueComponent>\
                  </OutsideDiameter><SubWireElementSpecification>core-element<";
    let whole = cabled(&["w3"]).replacen("<SubWireElementSpecification>core-element<", jacket, 1);
    assert_eq!(said(&whole), none);
    // What belongs to other modules is left out as such.
    let selection = Selection::Modules(vec!["right".to_owned()]);
    let modules = without("q4", &modular());
    let told = import(&modules, &Options { selection, ..Options::default() }).unwrap().findings;
    assert!(told.iter().all(|own| !own.what.contains("no routing")), "{told:#?}");
}

/// An element may state its class though the schema knows it: the class then has another name than the element.
#[test]
fn elements_that_state_their_own_class_are_not_dropped() {
    const CLASSES: [(&str, &str); 7] = [
        ("CartesianPoint", "CartesianPoint3D"),
        ("Component", "PartOccurrence"),
        ("GeometryNode", "GeometryNode3D"),
        ("GeometrySegment", "GeometrySegment3D"),
        ("PlacedElementViewItem3D", "OccurrenceOrUsageViewItem3D"),
        ("SubWireElement", "WireElement"),
        ("TopologySegment", "TopologySegment"),
    ];
    let stated = |text: &str| {
        CLASSES.iter().fold(text.to_owned(), |text, (element, class)| {
            let bare = format!("<{element} id=");
            assert!(text.contains(&bare), "{element}");
            text.replace(&bare, &format!("<{element} xsi:type=\"vec:{class}\" id="))
        })
    };
    let (ours, plain) = (imported(&stated(VEC_2_1)), imported(VEC_2_1));
    assert_eq!((lines(&ours.scenario), &ours.wires), (lines(&plain.scenario), &plain.wires));
    assert_eq!(row(&ours, "PartOccurrence"), row(&plain, "Component"));
    let text = stated(&modular());
    assert_eq!(contents(&text).unwrap(), contents(&modular()).unwrap());
    let scenario = |text: &str| {
        let selection = Selection::Modules(vec!["left".to_owned()]);
        import(text, &Options { selection, ..Options::default() }).unwrap().scenario
    };
    assert_eq!(lines(&scenario(&text)), lines(&scenario(&modular())));
}

#[test]
fn of_several_lengths_of_one_class_the_first_is_not_taken_silently() {
    let second = "<LengthInformation id=\"l2q-i\"><Length id=\"l2q\"><UnitComponent>uM</UnitComponent><ValueComponent>\
                  0.3</ValueComponent></Length><Classification>Adapted</Classification></LengthInformation>\
                  <LengthInformation id=\"l2p-i\">";
    let text = with("<LengthInformation id=\"l2p-i\">", second);
    let what = "segments have several lengths of one class; the first is taken";
    assert!(findings(&text).contains(&format!("{what}: s2 (Adapted)")), "{:#?}", findings(&text));
    assert_eq!(checked(&imported(&text).scenario).branches[1].length, 0.3);
    assert!(!findings(VEC_2_1).iter().any(|own| own.starts_with(what)));
}

/// Every broken form of the file is refused or imported into TOML with finite numbers; none panics.
#[test]
fn no_mutation_panics() {
    let snippets = ["s1 s2", "FromEndNode", "</TopologyNode>"];
    let [accepted, refused] = mutated(VEC_2_1, 20_261_126, &snippets, |text| import(text, &Options::default()));
    assert!(accepted > 200 && refused > 1000, "{accepted} accepted, {refused} refused");
}

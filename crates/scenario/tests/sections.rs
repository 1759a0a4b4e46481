//! Sections from their wires: independently computed cases, bounds, monotony, measured values, libraries in files.

mod common;

use wireloom_scenario::bundle::{Between, Bundle, Covered, Covering, Layer, Material, Measured, PACKING, Wire, Wires};
use wireloom_scenario::{Files, Scenario, parse, parse_with_files, render};

const HARNESS: &str = include_str!("branch.toml");

/// A solid wire of 1 mm in PVC to 2 mm.
const SOLID: &str = r#"
[wires.solid]
strands = 1
strand = "1 mm"
layers = [{ material = "pvc", diameter = "2 mm" }]
"#;

/// A scenario whose section has these keys.
fn read(section: &str, rest: &str) -> Scenario {
    let text = format!("schema = 1\n[sections.s]\n{section}\n{rest}{HARNESS}");
    parse(&text, &common::registry()).unwrap_or_else(|faults| panic!("{}", render(&text, &faults)))
}

fn refused(section: &str, rest: &str) -> String {
    let text = format!("schema = 1\n[sections.s]\n{section}\n{rest}{HARNESS}");
    parse(&text, &common::registry()).err().map(|faults| render(&text, &faults)).unwrap_or_default()
}

#[track_caller]
fn close(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-9, "{found:e}, not {expected:e}");
}

#[track_caller]
fn between(found: Between, slip: f64, taken: f64, bonded: f64) {
    close(found.slip, slip);
    close(found.taken, taken);
    close(found.bonded, bonded);
}

/// The rods of this crate's tests say no law: a section that is not linear would be bent as if it were, whatever the
/// kind.
#[test]
fn laws_are_refused_where_the_rod_does_not_say_them() {
    let laws = [
        ("", ""),
        ("friction = { torsion = [{ stiffness = 0.01, moment = 0.02 }] }", "`friction`"),
        ("creep = { bending = [{ stiffness = 0.01, time = \"2 h\" }] }", "`creep`"),
        ("set = { yield_curvature = 2, hardening = 0.1 }", "`set`"),
        ("compression_stiffness = 10", "an axial law"),
        (
            "friction = { bending = [{ stiffness = 1, moment = 1 }] }\ncompression_stiffness = 10",
            "`friction`, an axial law",
        ),
    ];
    for (law, words) in laws {
        let section = "diameter = 0.008\nlinear_density = 0.1\naxial_stiffness = 1e4\nbending_stiffness = 0.01\n\
                       torsion_stiffness = 0.01\n";
        let said = refused(&format!("{section}{law}"), "");
        let want = format!("its section \"s\" has {words}, and its rod \"cosserat\" does not say that it models this");
        assert!(if law.is_empty() { said.is_empty() } else { said.contains(&want) }, "{law}: {said}");
    }
}

/// E π d⁴/64 of copper and of PVC, independently: 120 GPa · 0.04909 mm⁴ + 50 MPa · 0.7363 mm⁴.
#[test]
fn one_solid_wire_is_itself() {
    let scenario = read("wires = [{ type = \"solid\" }]", SOLID);
    let section = &scenario.sections[0];
    let bending = 0.005_927_301_764_390_117_4;
    assert_eq!(section.diameter, 0.002);
    close(section.bending_stiffness[0], bending);
    close(section.torsion_stiffness, 0.004_421_275_269_730_135);
    close(section.axial_stiffness, 94_365.589_332_203_4);
    close(section.shear_stiffness[1], 94_365.589_332_203_4 / 2.6);
    close(section.linear_density, 0.010_218_030_105_800_802);
    close(section.min_bend_radius.unwrap(), 0.008);
    // 200 MPa · π/4 mm²
    close(section.max_tension.unwrap(), 157.079_632_679_489_66);
    between(scenario.by_rule[0].bundle.bending, bending, bending, bending);
}

/// Seven of them, loose: D² = 28/0.75 mm²; bonded 7 EI + 7 EA (D² − 4 mm²)/16; taken slip^0.95 · bonded^0.05.
#[test]
fn seven_wires_lie_between_slip_and_bonded() {
    let scenario = read("wires = [{ type = \"solid\", count = 7 }]", SOLID);
    let bundle = &scenario.by_rule[0].bundle;
    close(scenario.sections[0].diameter, 6.110_100_926_607_786e-3);
    between(bundle.bending, 0.041_491_112_350_730_82, 0.049_503_495_560_850_51, 1.417_655_956_778_696_8);
    between(bundle.torsion, 0.030_948_926_888_110_94, 0.036_926_344_601_729_85, 1.057_937_616_759_727_2);
    close(scenario.sections[0].min_bend_radius.unwrap(), 4.0 * 6.110_100_926_607_786e-3);
    // The exact second moment of seven bonded wires around one another, Σ r²/2 = 3 D_w² each way, is no more than
    // that.
    let exact = 7.0 * 0.005_927_301_764_390_117_4 + 94_365.589_332_203_4 * 3.0 * 4e-6;
    assert!(exact < bundle.bending.bonded && exact > 0.7 * bundle.bending.bonded);
}

/// 24 stranded wires under tape, 2 · 0.13 mm: strands at cohesion 0.1, then wires and tape at 0.12.
#[test]
fn a_taped_bundle_of_stranded_wires() {
    let scenario = read("wires = [{ type = \"FLRY-B 0.5\", count = 24 }]\ncovering = \"pvc tape, half lap\"", "");
    let (section, bundle) = (&scenario.sections[0], &scenario.by_rule[0].bundle);
    between(bundle.bending, 0.003_946_248_779_953_748, 0.012_544_493_610_217_127, 6.552_990_634_298_016);
    between(bundle.torsion, 0.002_926_441_578_075_615_3, 0.009_314_630_172_923_25, 4.890_179_606_734_23);
    close(section.diameter, 9.570_966_799_187_808e-3);
    close(section.linear_density, 0.157_294_719_337_830_2);
    close(section.axial_stiffness, 1_304_503.677_236_088_6);
    close(section.min_bend_radius.unwrap(), 4.0 * 9.050_966_799_187_808e-3);
    close(bundle.wires_bending, 24.0 * 0.000_222_642_147_374_908_4);
    // 24 · 0.9 · 200 MPa · 16 strands of 0.2 mm
    close(section.max_tension.unwrap(), 24.0 * 0.9 * 200e6 * 16.0 * std::f64::consts::PI / 4.0 * 0.2e-3 * 0.2e-3);
}

/// A solid copper wire and one of copper-clad steel, 1 mm each: copper breaks first, at 200 MPa/120 GPa, where the
/// other one bears 170 GPa times that.
#[test]
fn a_bundle_bears_what_breaks_its_first_conductor() {
    let two = "wires = [{ type = \"solid\" }, { type = \"clad\" }]";
    let clad = format!(
        "{SOLID}\n[wires.clad]\nlike = \"solid\"\nconductor = \"copper-clad steel\"\n\
         [wires.odd]\nlike = \"solid\"\nconductor = \"odd\"\n\
         [materials.odd]\nmodulus = \"1 GPa\"\npoisson = 0.3\ndensity = \"1 g/cm3\"\n"
    );
    let area = std::f64::consts::PI / 4.0 * 1e-6;
    let tension = |section: &str| read(section, &clad).sections[0].max_tension;
    close(tension(two).unwrap(), 200e6 / 120e9 * (120e9 + 170e9) * area);
    // A conductor of unknown strength makes that of the bundle unknown, and the note says so.
    let odd = "wires = [{ type = \"solid\" }, { type = \"odd\" }]";
    assert_eq!(tension(odd), None);
    let note = |section: &str| read(section, &clad).build(&common::registry()).ok().unwrap().notes[0].clone();
    assert!(note(odd).ends_with("; largest tension unknown"), "{}", note(odd));
    // A given value goes before the rule.
    let given = format!("{odd}\nmax_tension = \"90 N\"");
    assert_eq!(tension(&given), Some(90.0));
    assert!(note(&given).ends_with("; largest tension 90 N measured"), "{}", note(&given));
}

#[test]
fn cohesion_goes_from_sliding_to_glued() {
    let with = |cohesion: &str| {
        let keys = format!("wires = [{{ type = \"solid\", count = 7 }}]\ncohesion = {cohesion}");
        read(&keys, SOLID).sections[0].bending_stiffness[0]
    };
    close(with("0"), 0.041_491_112_350_730_82);
    close(with("1"), 1.417_655_956_778_696_8);
    close(with("0.5"), (0.041_491_112_350_730_82_f64 * 1.417_655_956_778_696_8).sqrt());
}

/// Six wires of AWG 30 in the cable of `scenarios/measured/reality.md`, sample 6. While they stick the whole cable has
/// 12 to 15e-4 N m², a seventh of what its wires alone have as a solid: the bonded stiffness is a bound, and no
/// estimate of it.
#[test]
fn a_measured_cable_that_sticks_is_far_softer_than_its_bonded_wires() {
    let wire = "[wires.thin]\nstrands = 7\nstrand = \"0.1 mm\"\n\
                layers = [{ material = \"pvc\", diameter = \"0.8 mm\" }]\n";
    let bending = read("wires = [{ type = \"thin\", count = 6 }]", wire).by_rule[0].bundle.bending;
    assert!(bending.bonded > 6.0 * 15e-4 && bending.bonded < 12e-3, "{bending:?}");
    // With the insulation and two braids, of unknown material, the cable that slips has 4e-4 N m².
    assert!(bending.slip < 4e-4, "{bending:?}");
}

/// Half the branch under a stiff tube, half bare: curvatures under one moment add up.
#[test]
fn a_covering_over_a_part_lies_in_series() {
    let wires = "wires = [{ type = \"FLRY-B 1.0\", count = 10 }]";
    let tube = "[coverings.tube]\nmaterial = \"pvc\"\nthickness = \"1 mm\"\ninner_diameter = \"10 mm\"\n\
                bending_stiffness = 0.3\nlinear_density = \"100 g/m\"\n";
    let bare = &read(wires, "").sections[0];
    let all = &read(&format!("{wires}\ncovering = \"tube\""), tube).sections[0];
    let half = &read(&format!("{wires}\ncovering = [{{ type = \"tube\", share = 0.5 }}]"), tube).sections[0];
    let series = |a: f64, b: f64| 1.0 / (0.5 / a + 0.5 / b);
    close(half.bending_stiffness[0], series(bare.bending_stiffness[0], all.bending_stiffness[0]));
    close(half.torsion_stiffness, series(bare.torsion_stiffness, all.torsion_stiffness));
    close(half.linear_density, bare.linear_density + 0.05);
    assert!(all.bending_stiffness[0] > 0.3 && all.bending_stiffness[0] < 0.4);
    assert_eq!((half.diameter, all.diameter), (0.012, 0.012));
}

#[test]
fn measured_values_go_before_the_rule_and_are_called_so() {
    let wires = "wires = [{ type = \"FLRY-B 0.5\", count = 24 }]\ncovering = [\"pvc tape, half lap\"]";
    let plain = read(wires, "");
    let mixed = read(&format!("{wires}\nbending_stiffness = [0.02, 9.0]\ndiameter = \"11 mm\""), "");
    let (plain_section, section) = (&plain.sections[0], &mixed.sections[0]);
    assert_eq!((section.bending_stiffness, section.diameter), ([0.02, 9.0], 0.011));
    assert_eq!(section.torsion_stiffness, plain_section.torsion_stiffness);
    assert_eq!(section.linear_density, plain_section.linear_density);
    let note = |scenario: &Scenario| scenario.build(&common::registry()).ok().unwrap().notes[0].clone();
    let all = note(&plain);
    assert!(
        all.starts_with(
            "section \"s\", 24 wires under \"pvc tape, half lap\": EI 0.013 N m² (slip 0.0039, bonded 6.6); \
             GJ 0.0093 N m² (slip 0.0029, bonded 4.9); EA 1.3e6 N; diameter 9.6 mm; 160 g/m"
        ),
        "{all}"
    );
    let some = note(&mixed);
    assert!(
        some.contains(
            "EI [0.02, 9] N m² measured (rule 0.013; slip 0.0039, bonded 6.6; outside these bounds); GJ 0.0093"
        ) && some.contains("diameter 11 mm measured; 160 g/m;"),
        "{some}"
    );
}

#[test]
fn many_sections_have_one_note_and_a_list() {
    let more: String = (0..7)
        .map(|k| format!("[sections.s{k}]\nwires = [{{ type = \"FLRY-B 0.5\", count = {} }}]\n", k + 1))
        .collect();
    let built = read("wires = [{ type = \"FLRY-B 0.5\" }]", &more).build(&common::registry()).ok().unwrap();
    assert_eq!(built.notes.len(), 1, "{:?}", built.notes);
    assert!(built.notes[0].starts_with("8 sections follow from their wires by rule"), "{}", built.notes[0]);
    assert_eq!(built.sections.len(), 8);
    assert!(built.sections[2].starts_with("section \"s1\", 2 wires: EI "), "{}", built.sections[2]);
}

#[test]
fn a_tube_narrower_than_its_wires_is_remarked() {
    let built = read("wires = [{ type = \"FLRY-B 2.5\", count = 20 }]\ncovering = \"corrugated tube NW 10\"", "");
    let remarks = &built.by_rule[0].remarks;
    assert_eq!(*remarks, ["\"corrugated tube NW 10\" is 9.8 mm wide inside, the wires are 15.5 mm thick"]);
    assert!(built.sections[0].diameter > 0.0155);
}

// ---- Bounds and monotony, on random bundles ------------------------------------------------------------------------

/// A fixed sequence of pseudo-random numbers (xorshift).
struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        self.within(0.0, n as f64) as usize
    }

    /// Spread evenly over powers of ten.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    fn material(&mut self) -> Material {
        Material {
            modulus: self.scale(1e6, 2e11),
            poisson: self.within(0.0, 0.5),
            density: self.within(500.0, 9000.0),
            strength: Some(self.scale(1e6, 1e9)),
        }
    }

    fn measured(&mut self) -> Measured {
        if self.below(4) > 0 {
            return Measured::default();
        }
        Measured { bending_stiffness: Some(self.scale(1e-5, 1e-2)), ..Measured::default() }
    }

    fn wire(&mut self) -> Wire {
        let (strands, strand) = (1 + self.below(60), self.scale(1e-4, 1e-3));
        let conductor_diameter = Wire::conductor_diameter_of(strands, strand);
        let mut layers = Vec::new();
        let mut diameter = conductor_diameter;
        for _ in 0..1 + self.below(3) {
            diameter *= self.within(1.05, 2.0);
            let strand = (self.below(3) == 0).then(|| self.scale(5e-5, 2e-4));
            layers.push(Layer { material: self.material(), diameter, fill: self.within(0.1, 1.0), strand });
        }
        let (conductor, measured) = (self.material(), self.measured());
        Wire { strands, strand, conductor, conductor_diameter, layers, measured }
    }

    fn covering(&mut self) -> Covering {
        let inner_diameter = (self.below(3) == 0).then(|| self.scale(1e-3, 3e-2));
        let thickness = self.scale(1e-4, 2e-3);
        let extra = self.below(2);
        Covering {
            material: self.material(),
            thickness,
            layers: 1 + extra,
            wrap: self.below(2) == 0,
            coverage: self.within(0.05, 1.0),
            inner_diameter,
            outer_diameter: inner_diameter.filter(|_| self.below(2) == 0).map(|d| 1.3 * d + 4.0 * thickness),
            bending_share: self.within(0.0, 1.0),
            torsion_share: self.within(0.0, 1.0),
            cohesion: self.within(0.0, 1.0),
            measured: self.measured(),
        }
    }
}

#[test]
fn the_value_lies_between_its_bounds_and_grows_with_every_wire() {
    let mut random = Random(0x2545_F491_4F6C_DD1D);
    for _ in 0..3000 {
        let wires: Vec<Wire> = (0..1 + random.below(3)).map(|_| random.wire()).collect();
        let mut counts: Vec<usize> = wires.iter().map(|_| 1 + random.below(40)).collect();
        let coverings: Vec<Covering> = (0..random.below(4)).map(|_| random.covering()).collect();
        let shares: Vec<f64> =
            coverings.iter().map(|_| if random.below(2) == 0 { 1.0 } else { random.within(0.01, 1.0) }).collect();
        let covered: Vec<Covered<'_>> =
            coverings.iter().zip(&shares).map(|(covering, &share)| Covered { covering, fraction: share }).collect();
        let packing = (random.below(3) == 0).then(|| random.within(0.4, 0.9));
        let cohesion = (random.below(3) == 0).then(|| random.within(0.0, 1.0));
        let bundle = |counts: &[usize]| {
            let contents: Vec<Wires<'_>> =
                wires.iter().zip(counts).map(|(wire, &count)| Wires { wire, count }).collect();
            Bundle::new(&contents, &covered, packing, cohesion)
        };
        let fewer = bundle(&counts);
        for x in [fewer.bending, fewer.torsion] {
            let (slip, bonded) = (x.slip * (1.0 - 1e-12), x.bonded * (1.0 + 1e-12));
            assert!(x.slip > 0.0 && slip <= x.taken && x.taken <= bonded && bonded.is_finite(), "{fewer:?}");
        }
        let one = random.below(counts.len());
        counts[one] += 1 + random.below(3);
        let more = bundle(&counts);
        let grows = |of: fn(&Bundle) -> f64| of(&more) >= of(&fewer) * (1.0 - 1e-12);
        assert!(grows(|b| b.bending.slip) && grows(|b| b.bending.taken) && grows(|b| b.bending.bonded));
        assert!(grows(|b| b.torsion.slip) && grows(|b| b.torsion.taken) && grows(|b| b.torsion.bonded));
        assert!(grows(|b| b.diameter) && grows(|b| b.linear_density) && grows(|b| b.axial_stiffness));
        assert!(grows(|b| b.min_bend_radius) && grows(|b| b.max_tension.unwrap()));
    }
}

/// The diameter of few equal wires against that of the circle around them: exact for one and two, within 7 % up to
/// seven.
#[test]
fn few_wires_have_the_diameter_of_the_circle_around_them() {
    let wire = Wire {
        strands: 1,
        strand: 0.5e-3,
        conductor: Material { modulus: 1e11, poisson: 0.3, density: 9000.0, strength: None },
        conductor_diameter: 0.5e-3,
        layers: vec![Layer {
            material: Material { modulus: 1e8, poisson: 0.4, density: 1300.0, strength: None },
            diameter: 1e-3,
            fill: 1.0,
            strand: None,
        }],
        measured: Measured::default(),
    };
    for (count, circle) in [(1, 1.0), (2, 2.0), (3, 2.1547), (4, 2.4142), (5, 2.7013), (6, 3.0), (7, 3.0)] {
        let found = Bundle::new(&[Wires { wire: &wire, count }], &[], Some(PACKING), None).diameter * 1e3;
        assert!((found / circle - 1.0).abs() < 0.08, "{count}: {found}, not {circle}");
    }
}

// ---- Libraries ------------------------------------------------------------------------------------------------------

struct Folder;

impl Files for Folder {
    fn read(&self, path: &str) -> Result<String, String> {
        match path {
            "ours.toml" => Ok(format!(
                "{SOLID}[materials.copper]\nmodulus = \"60 GPa\"\npoisson = 0.34\ndensity = \"8960 kg/m3\"\n"
            )),
            "again.toml" => Ok(SOLID.into()),
            "bad.toml" => Ok("[wires.w]\nstrands = 0\nstrand = \"1 mm\"\nlayer = []\n".into()),
            _ => Err("no such file".into()),
        }
    }
}

fn with_files(files: &str) -> Result<Scenario, String> {
    let text =
        format!("schema = 1\n[library]\nfiles = {files}\n[sections.s]\nwires = [{{ type = \"solid\" }}]\n{HARNESS}");
    parse_with_files(&text, &Folder, &common::registry()).map_err(|faults| render(&text, &faults))
}

#[test]
fn files_add_types_and_replace_shipped_ones() {
    // Materials of a file count for the wires of the same file: copper half as stiff.
    let section = &with_files("[\"ours.toml\"]").unwrap().sections[0];
    close(section.bending_stiffness[0], 0.005_890_486_225_480_862 / 2.0 + 3.681_553_890_925_539e-5);
}

#[test]
fn faults_of_files_stand_where_they_are_named() {
    let faults = with_files("[\"ours.toml\", \"again.toml\", \"bad.toml\", \"none.toml\"]").unwrap_err();
    let lines: Vec<&str> = faults.lines().filter(|line| !line.starts_with("  help")).collect();
    assert_eq!(
        lines,
        [
            "3:23: again.toml:1:1: another file has wire \"solid\" too",
            "3:37: bad.toml:2:11: `strands` = 0 is out of range",
            "3:37: bad.toml:4:1: unknown key `layer` in wire \"w\"",
            "3:49: cannot read \"none.toml\": no such file",
        ],
        "{faults}"
    );
}

#[test]
fn a_type_at_fault_is_no_unknown_type() {
    let faults = refused("wires = [{ type = \"w\" }]", "[wires.w]\nstrands = 7\nstrand = \"2 m\"\nlayers = []\n");
    assert_eq!(faults.lines().count(), 2, "{faults}");
    assert!(faults.contains("wire \"w\" has no layers"), "{faults}");
}

#[test]
fn a_type_like_another_has_what_it_does_not_say() {
    let types = "[wires.ours]\nlike = \"FLRY-B 0.5\"\nlinear_density = \"7 g/m\"\n\
                 [wires.double]\nlike = \"FLRY-B 0.5\"\nstrands = 32\n\
                 layers = [{ material = \"pvc\", diameter = \"2 mm\" }]\n\
                 [coverings.ours]\nlike = \"pvc tape, half lap\"\nlayers = 3\n";
    let section = |wire: &str, covering: &str| {
        let keys = format!("wires = [{{ type = \"{wire}\", count = 24 }}]\ncovering = \"{covering}\"");
        read(&keys, types).sections[0].clone()
    };
    let (shipped, ours) = (section("FLRY-B 0.5", "pvc tape, half lap"), section("ours", "pvc tape, half lap"));
    assert_eq!(ours.bending_stiffness, shipped.bending_stiffness);
    close(ours.linear_density - shipped.linear_density, 24.0 * (0.007 - 0.006_157_835_760_301_353_5));
    let double = section("double", "pvc tape, half lap");
    assert!((double.axial_stiffness / shipped.axial_stiffness - 2.0).abs() < 0.01, "{}", double.axial_stiffness);
    close(section("ours", "ours").diameter - shipped.diameter, 2.0 * 0.13e-3);
    let wire = "[wires.w]\nlike = \"FLRY-B 0.5\"\nstrands = 320\n[wires.v]\nlike = \"FLRY-C 0.5\"\n";
    let faults = refused("wires = [{ type = \"w\" }, { type = \"v\" }]", wire);
    assert!(faults.contains("layer 1 of wire \"w\" is not thicker than the one below it"), "{faults}");
    assert!(faults.contains("unknown wire type \"FLRY-C 0.5\" in wire \"v\""), "{faults}");
    assert_eq!(faults.lines().count(), 4, "{faults}");
}

#[test]
fn wires_that_make_an_impossible_section_are_refused() {
    let wire = "[wires.w]\nstrands = 1\nstrand = 100\nlayers = [{ material = \"pvc\", diameter = 200 }]\n";
    let faults = refused("wires = [{ type = \"w\", count = 1000 }]", wire);
    assert!(faults.contains("the wires of section \"s\" give it a `diameter` of 7.303e3 m"), "{faults}");
    assert!(faults.contains("it must be from 1e-10 to 1000 m"), "{faults}");
    let wire = "[wires.w]\nstrands = 1\nstrand = 1e200\nlayers = [{ material = \"pvc\", diameter = 1e201 }]\n";
    let faults = refused("wires = [{ type = \"w\" }]", wire);
    assert!(faults.contains("`strand` = 1e200 is too large"), "{faults}");
}

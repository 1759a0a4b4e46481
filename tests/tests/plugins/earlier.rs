//! Plugins that were built with the header of an earlier ABI, each family of parts with the first one that had it.

use crate::*;

/// ABI, and which families its header has: spring, hub, rod.
const EARLIER: [(&str, [bool; 3]); 4] =
    [("1.0", [true, false, false]), ("1.1", [true, true, false]), ("1.7", [true; 3]), ("1.8", [true; 3])];

pub fn trials() -> Vec<Named> {
    let trial = |(abi, has): &'static (&str, [bool; 3])| -> Named {
        let name = format!("a plugin built with the header of ABI {abi} gives what it gives with that of today");
        (name, Box::new(move || is_what_it_is_today(abi, *has)))
    };
    EARLIER.iter().map(trial).collect()
}

/// Runs a harness with the parts that this header has; `folder` has the header, none: that of today.
fn run(folder: Option<&str>, [_, hub, rod]: [bool; 3]) -> Result<Value, Failed> {
    let place = Place::new()?;
    let here = root().join("tests/tests/plugins");
    let include = folder.map(|abi| format!("-iquote{}", here.join("headers").join(abi).display()));
    let more: Vec<&str> = include.iter().map(String::as_str).collect();
    compile(&here.join("earlier.c"), &place.path("libearlier.so"), &more)?;
    let model = if hub { "earlier-hub" } else { "rigid-body" };
    let rod = if rod { "rod = \"earlier-rod\"" } else { "" };
    let branch = |name: &str, to: &str, rod: &str| {
        format!(
            "[[branches]]\nname = \"{name}\"\nfrom = \"J\"\nto = \"{to}\"\nsection = \"cable\"\nlength = 0.4\n\
             segments = 16\n{rod}\n"
        )
    };
    let arm = |branch: &str, x: i32| {
        format!(
            "{{ branch = \"{branch}\", direction = [{x}, 0, 0], up = [0, 0, 1], offset = [{}, 0, 0] }}",
            0.01 * f64::from(x)
        )
    };
    let text = [
        "schema = 1\nname = \"earlier\"\nplugins = { load = [\"earlier\"] }\n[sections.cable]\ndiameter = \"6 mm\"\n\
         linear_density = 0.05\naxial_stiffness = 1e4\nbending_stiffness = 0.01\ntorsion_stiffness = 0.008\n",
        &branch("left", "A", ""),
        &branch("right", "B", rod),
        &format!("[[joints]]\nname = \"J\"\nmodel = \"{model}\"\narms = [{}, {}]\n", arm("left", -1), arm("right", 1)),
        "[[constraints]]\nname = \"A\"\nkind = \"connector\"\nat = { end = \"A\" }\nposition = [-0.41, 0, 0]\n\
         tangent = [-1, 0, 0]\nup = [0, 0, 1]\n\
         [[constraints]]\nname = \"spring\"\nkind = \"earlier-spring\"\nat = { end = \"B\" }\nstiffness = 5\n\
         position = [0.38, 0.02, 0.05]\n[[steps]]\nname = \"hang\"\n[minimiser]\nforce_tolerance = 1e-10\n",
    ]
    .concat();
    fs::write(place.path("s.toml"), text)?;
    place.wireloom(&["run", "s.toml", "--allow-plugin", "libearlier.so"])?.expect(0)?;
    place.json("out/s/result.json")
}

fn is_what_it_is_today(abi: &str, has: [bool; 3]) -> Checked {
    let (earlier, today) = (run(Some(abi), has)?, run(None, has)?);
    let pull = "/steps/0/constraints/spring/outputs";
    ensure(today.pointer(pull).is_some_and(|pull| number(pull, "/x") != 0.0), &today["steps"][0]["constraints"])?;
    let mut today = today;
    if earlier.pointer(pull).is_none() {
        // Its header has no outputs.
        today["steps"][0]["constraints"]["spring"].as_object_mut().ok_or("a spring")?.remove("outputs");
    }
    let parts = ["/steps/0/branches", "/steps/0/constraints", "/steps/0/joints"];
    for part in parts {
        let [then, now] = [&earlier, &today].map(|result| result.pointer(part));
        ensure(then.is_some() && then == now, format!("{part}: {then:?} beside {now:?}"))?;
    }
    Ok(())
}

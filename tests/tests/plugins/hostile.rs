//! Plugins that do one thing wrong each. Whatever it is, the program ends by itself, with the code it should and with
//! words that say what is wrong, whose doing it was, and where; and what was computed before is kept.

use crate::*;
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use wireloom::plugins::Plugins;
use wireloom_tests::cables::{branch, connector, section};

/// A cantilever, with the plugin's spring at its end.
pub fn scenario() -> String {
    [
        HEAD,
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.5, 10),
        &connector("clamp", "A", [0.0, 0.0, 0.0]),
        TAIL,
    ]
    .concat()
}

const HEAD: &str = r#"schema = 1
name = "hostile"
gravity = [0, 0, 0]

[plugins]
load = ["hostile"]
time_limit = 0.5

"#;

const TAIL: &str = r#"
[[constraints]]
name = "bad"
kind = "hostile"
at = { end = "B" }
position = [0.5, 0, "10 mm"]

[[loads]]
name = "tool"
at = { end = "B" }
force = [0, 0.001, 0]
factor = 0

[[steps]]
name = "first"

[[steps]]
name = "second"
increments = 2
[[steps.load]]
load = "tool"
factor = 1
"#;

/// Case of `hostile.c`, what it does, what must be said.
type Case = (u32, &'static str, &'static [&'static str]);

/// Refused before anything is computed.
const REFUSED: &[Case] = &[
    (1, "exports nothing", &["exports no `wireloom_plugin`"]),
    (2, "wrong magic", &["begins with 0x1122334455667788 instead of 0x4d4f4f4c45524957, the letters WIRELOOM"]),
    (3, "another major version", &["is built for ABI 2.", "this program speaks ABI 1."]),
    (
        4,
        "a later minor version",
        &["is built for ABI 1.900, this program speaks ABI 1.", "a later version of this program"],
    ),
    (5, "a kind without a name", &["the name of kind 1 is empty"]),
    (6, "a kind with the name of a built-in one", &["its kind `collar` already exists, from the program itself"]),
    (7, "a name that is not UTF-8", &["the name of kind 1 is not UTF-8"]),
    (8, "an unknown family", &["the family of kind `hostile` is 4"]),
    (9, "no table of functions", &["the table of functions of kind `hostile` is null"]),
    (10, "two kinds of one name", &["kind `hostile` occurs twice"]),
    (11, "parameters that overlap", &["array of parameters of kind `hostile` says it has 3 bytes; ABI 1.0 has"]),
    (12, "a short table of functions", &["table of functions of kind `hostile` says it has 8 bytes; ABI 1.0 has"]),
    (13, "more stations at least than at most", &["the number of stations of kind `hostile` is 3 to 1"]),
    (14, "a huge stencil", &["the number of stations of kind `hostile` is 1 to 1000000"]),
    (15, "an unknown use of spans", &["`span` of kind `hostile` is 3"]),
    (16, "no create", &["the function `create` of kind `hostile` is null"]),
    (17, "no destroy", &["the function `destroy` of kind `hostile` is null"]),
    (18, "no evaluate", &["plugin `hostile` 0.0.1 (libhostile.so) has no function `evaluate`", "constraint \"bad\""]),
    (19, "very many parameters", &["number of parameters of kind `hostile` is 100000"]),
    (20, "a parameter whose name is none", &["the name of parameter 1 of kind `hostile` is \"no name\""]),
    (21, "an unknown form of parameter", &["the form of parameter 1 of kind `hostile` (`one`) is 17"]),
    (22, "an unknown quantity", &["the quantity of parameter 1 of kind `hostile` (`one`) is 99"]),
    (23, "an unknown presence", &["the presence of parameter 1 of kind `hostile` (`one`) is 5"]),
    (24, "a range from nothing", &["the range of parameter 1 of kind `hostile` (`one`) is NaN to 1"]),
    (25, "a default out of its range", &["the default of parameter 1 of kind `hostile` (`one`) is [7.0, 0.0, 0.0]"]),
    (26, "two parameters of one name", &["parameter `one` of kind `hostile` occurs twice"]),
    (27, "a parameter without a doc", &["the doc of parameter 2 of kind `hostile` (`other`) is null"]),
    (28, "a choice without words", &["the words of parameter 2 of kind `hostile` (`other`) is null"]),
    (29, "a choice of nothing", &["the number of words of parameter 2 of kind `hostile` (`other`) is 0"]),
    (
        30,
        "a constraint that is refused",
        &["(libhostile.so) refuses: I will not, since it is Saturday", "constraint \"bad\""],
    ),
    (31, "an unknown status", &["(libhostile.so) returned 77 from `create`"]),
    (32, "no instance", &["returned success from `create` but wrote no instance"]),
    (33, "no description", &["wrote no shape: `create` must fill in the description"]),
    (70, "a memory that is not finite", &["starts with a memory that is not finite: [NaN]"]),
    (71, "an unknown shape", &["has shape 99; 1 to 4 are known"]),
    (72, "equations without residuals", &["has no residuals"]),
    (73, "a huge memory", &["says it has 4000000000 numbers of memory"]),
    (74, "a memory at no address", &["has its memory at 0x8"]),
    (75, "a hold of nothing", &["prescribes nothing: neither position nor rotation"]),
    (76, "five rails", &["has 5 rails"]),
    (77, "an unknown way to hold", &["holds rotations in way 12"]),
    (80, "a short list of kinds", &["list of kinds says it has 4 bytes; ABI 1.0 has"]),
    (81, "billions of kinds", &["its number of kinds is 4000000000"]),
    (82, "no kinds", &["could not list its kinds: it has none"]),
    (83, "kinds that overlap", &["array of kinds says it has 8 bytes; ABI 1.0 has"]),
    (84, "kinds as large as the memory", &["the size of its array of kinds is 4000000000"]),
    (85, "null for the kinds", &["its array of kinds is null"]),
    (86, "kinds at an odd address", &["its array of kinds is 0x", "which is not a valid address"]),
    (87, "kinds that cannot be listed", &["could not list its kinds: the licence server does not answer"]),
    (88, "a list of kinds at no address", &["its list of kinds is 0x18, which is not a valid address"]),
    (91, "an entry as large as the memory", &["the size of its entry is 4000000000"]),
    (92, "no name", &["the name of the plugin is null"]),
    (93, "a name without an end", &["the name of the plugin has no end"]),
    (94, "a name of two words", &["the name of the plugin is \"two words\""]),
    (95, "no version", &["its version is null"]),
    (96, "a doc that is not UTF-8", &["its doc is not UTF-8"]),
    (97, "no function that lists kinds", &["its function `kinds` is null"]),
    (
        98,
        "an extension at an odd address",
        &["its extension `wireloom.draft.notes/1` is 0x1, which is not a valid address"],
    ),
    (90, "a short entry", &["its entry says it has", "ABI 1.0 has"]),
    (53, "very many outputs", &["its number of outputs of kind `hostile` is 100000"]),
    (54, "outputs without a function", &["the function `report` of kind `hostile` is null"]),
    (55, "two outputs of one name", &["output `first` of kind `hostile` occurs twice"]),
    (56, "an unknown quantity of an output", &["the quantity of output 1 of kind `hostile` (`first`) is 99"]),
    (57, "outputs that overlap", &["array of outputs of kind `hostile` says it has 8 bytes"]),
];

/// Ends the process before anything is computed.
const ENDED: &[Case] = &[
    (
        34,
        "a crash in create",
        &["constraint `bad` (hostile): plugin `hostile` 0.0.1 (libhostile.so) crashed", "SIGSEGV", "(in `create`)"],
    ),
    (
        35,
        "an exit in create",
        &["constraint `bad` (hostile): plugin `hostile` 0.0.1 (libhostile.so) ended the process (exit) (in `create`)"],
    ),
    (36, "a create that never returns", &["did not return within 0.5 s (in `create`)"]),
    (50, "a crash as it is loaded", &["libhostile.so crashed", "(in `initialisation of the library`)"]),
    (
        52,
        "a start that never ends",
        &["libhostile.so did not return within 0.5 s (in `initialisation of the library`)"],
    ),
    (89, "a crash while it lists its kinds", &["libhostile.so crashed", "(in `kinds`)"]),
];

/// Goes wrong in the second step.
const FAILING: &[Case] = &[
    (37, "a crash in evaluate", &["crashed: invalid memory access (SIGSEGV) (in `evaluate`)"]),
    (38, "an evaluation that never returns", &["did not return within 0.5 s (in `evaluate`)"]),
    (39, "an abort", &["aborted the process (SIGABRT) (in `evaluate`)"]),
    (40, "an exit in evaluate", &["ended the process (exit) (in `evaluate`)"]),
    (41, "a recursion without an end", &["crashed: invalid memory access (SIGSEGV) (in `evaluate`)"]),
    (42, "an error in evaluate", &["failed in `evaluate`: the table has no entry for this"]),
    (43, "an unknown status from evaluate", &["returned -5 from `evaluate`"]),
    (44, "a message without an end", &["failed in `evaluate`: xxxx"]),
    (45, "an energy that is not a number", &["returned NaN as energy"]),
    (46, "a gradient that is not written", &["wrote no gradient, entry 0 of 6 in `evaluate`, which was requested"]),
    (47, "an infinite Hessian", &["returned inf as Hessian, entry 7 of 36"]),
    (101, "an exit that leaves no trace", &["ended the process without a trace (_exit, exit code 0) (in `evaluate`)"]),
];

/// Does no harm.
const HARMLESS: &[(u32, &str)] = &[
    (0, "nothing wrong"),
    (49, "closes itself while it is in use"),
    (61, "gives no Hessian"),
    (63, "was built before there were outputs"),
    (64, "has two outputs"),
];

pub fn trials() -> Vec<Named> {
    let mut all = vec![
        named("hostile: no library at all is refused with the loader's reason", no_library),
        named("hostile: an empty file is refused", empty_file),
        named("hostile: a memory that becomes not-a-number ends the run", bad_memory),
        named("hostile: a target that is not a number, or not turned but stretched, ends the run", bad_target),
        named("hostile: an output that is not a number, or not written, ends the run", bad_outputs),
        named("hostile: a crash as it is unmade ends the run, and all is kept", crash_at_the_end),
        named("hostile: plugin check says what is wrong, and in which function", checked),
        named("hostile: an exit at once as it is loaded is reported", silent_exit),
        named("hostile: damaged memory ends the run, the plugin is named, and all is kept", damaged_memory),
        named("hostile: an exception in C++ ends the run, the plugin is named, and all is kept", exception),
        named("hostile: Ctrl-C ends a call that does not return within a second, and all is kept", ctrl_c),
        named("hostile: the bytes that were hashed are those that run, also as a link flips meanwhile", flipping_link),
        named("hostile: a changed rounding mode is restored, and a note of the run", rounding_mode),
    ];
    for case in REFUSED {
        all.push((format!("hostile: {} is refused", case.1), Box::new(move || refused(case))));
    }
    for case in ENDED {
        all.push((format!("hostile: {} is reported", case.1), Box::new(move || ended(case))));
    }
    for case in FAILING {
        all.push((
            format!("hostile: {} ends the run, and the first step is kept", case.1),
            Box::new(move || failing(case)),
        ));
    }
    for (case, what) in HARMLESS {
        all.push((format!("hostile: {what} does no harm"), Box::new(move || harmless(*case))));
    }
    all
}

/// Runs the scenario with a case.
fn run(case: u32) -> Result<(Place, Ended), Failed> {
    let place = Place::new()?;
    let flag = format!("-DCASE={case}");
    // What is wrong on purpose is not to be warned of.
    let more = [&flag, "-Wno-infinite-recursion", "-Wno-unused-function", "-Wno-unused-variable", "-ldl"];
    compile(&root().join("tests/tests/plugins/hostile.c"), &place.path("libhostile.so"), &more)?;
    fs::write(place.path("s.toml"), scenario())?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libhostile.so"])?;
    Ok((place, ended))
}

fn refused((case, _, words): &Case) -> Checked {
    let (place, ended) = run(*case)?;
    let ended = ended.expect(1)?;
    ended.says(words)?;
    ended.says(&["s.toml:", "libhostile.so"])?;
    ensure(!place.path("out").exists(), "something was written")
}

fn ended((case, _, words): &Case) -> Checked {
    let (_place, ended) = run(*case)?;
    ended.expect(3)?.says(words)
}

fn failing((case, _, words): &Case) -> Checked {
    let (place, ended) = run(*case)?;
    let ended = ended.expect(3)?;
    ended.says(words)?;
    ended
        .says(&["constraint `bad` (hostile) in step `second`, increment 1: plugin `hostile` 0.0.1 (libhostile.so) "])?;
    let result = place.json("out/s/result.json")?;
    let fault = &result["fault"];
    ensure(fault["constraint"] == "bad" && fault["kind"] == "hostile" && fault["step"] == "second", &result)?;
    ensure(fault["increment"] == 1 && result["plugins"][0]["name"] == "hostile", &result)?;
    ensure(result["status"] == "failed", &result["status"])?;
    let steps = result["steps"].as_array().map_or(0, Vec::len);
    ensure(steps == 1 && result["steps"][0]["name"] == "first", &result)?;
    near("end", number(&result, "/steps/0/branches/cable/position/10/2"), 0.01 / 1.24, 1e-3)
}

/// The end is drawn towards 10 mm by 1 N/m against `3 EI / L³` = 0.24 N/m.
fn harmless(case: u32) -> Checked {
    let (place, ended) = run(case)?;
    let ended = ended.expect(0)?;
    let result = place.json("out/s/result.json")?;
    ensure(result["steps"].as_array().is_some_and(|steps| steps.len() == 2), &result)?;
    if case == 62 {
        ensure(ended.out.contains("note: constraint `bad` (hostile): mind the gap"), &ended)?;
    }
    let outputs = &result["steps"][1]["constraints"]["bad"]["outputs"];
    if case == 64 {
        ensure(outputs["first"] == 1.0 && outputs["second"] == 2.0, outputs)?;
    } else {
        ensure(outputs.is_null(), outputs)?;
    }
    if case == 61 {
        let words = "kind `hostile` of plugin `hostile` 0.0.1 (libhostile.so) gives not all derivatives: the Hessian \
                     is taken numerically";
        ensure(ended.out.contains(words), &ended)?;
    }
    near("end", number(&result, "/steps/1/branches/cable/position/10/2"), 0.01 / 1.24, 1e-3)
}

fn without_compiler(content: &[u8], words: &[&str]) -> Checked {
    let place = Place::new()?;
    fs::write(place.path("libhostile.so"), content)?;
    fs::write(place.path("s.toml"), scenario())?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libhostile.so"])?.expect(1)?;
    ended.says(&["s.toml:6:9: plugin libhostile.so: is not a library that this system can load: "])?;
    ended.says(words)
}

fn no_library() -> Checked {
    without_compiler(
        b"This is no library, but it is long enough to be taken for one at first sight.\n",
        &["libhostile.so"],
    )
}

fn empty_file() -> Checked {
    without_compiler(b"", &["libhostile.so"])
}

fn bad_memory() -> Checked {
    let (place, ended) = run(48)?;
    ended.expect(3)?.says(&["constraint `bad` (hostile) in step `", "returned NaN as memory"])?;
    no_converged_fault(&place)
}

/// Completed steps are kept, and the one with the fault is not called converged.
fn no_converged_fault(place: &Place) -> Checked {
    let result = place.json("out/s/result.json")?;
    ensure(result["fault"].is_object() && result["status"] == "failed", &result)
}

fn bad_target() -> Checked {
    let words =
        [(65, "returned NaN as target's position, entry 1 of 3"), (66, "returned a target with orientation [7, ")];
    for (case, words) in words {
        let (place, ended) = run(case)?;
        ended.expect(3)?.says(&["constraint `bad` (hostile) in step `first`", words])?;
        no_converged_fault(&place)?;
    }
    Ok(())
}

fn bad_outputs() -> Checked {
    let words = [(67, "returned NaN as output `first`"), (68, "wrote no value of the output `second` in `report`")];
    for (case, words) in words {
        let (place, ended) = run(case)?;
        ended.expect(3)?.says(&["constraint `bad` (hostile) in step `first`, increment 1: plugin", words])?;
        no_converged_fault(&place)?;
    }
    Ok(())
}

fn crash_at_the_end() -> Checked {
    let (place, ended) = run(60)?;
    ended.expect(3)?.says(&["crashed", "(in `destroy`)"])?;
    let result = place.json("out/s/result.json")?;
    ensure(result["steps"].as_array().is_some_and(|steps| steps.len() == 2), &result)
}

fn checked() -> Checked {
    for (case, code, words) in [(45, 3, "returned NaN as energy"), (46, 3, "wrote no gradient"), (34, 3, "crashed")] {
        let (place, _) = run(case)?;
        let ended = place.wireloom(&["plugin", "check", "libhostile.so", "--time-limit", "0.5"])?.expect(code)?;
        ensure(format!("{}{}", ended.out, ended.err).contains(words), &ended)?;
    }
    Ok(())
}

fn silent_exit() -> Checked {
    let (place, ended) = run(51)?;
    ended.expect(3)?.says(&[
        "libhostile.so ended the process without a trace (_exit, exit code 0) (in `initialisation of the library`)",
    ])?;
    ensure(!place.path("out").exists(), "something was written")
}

/// The first step is in the result, and the plugin is at fault in the second.
fn first_step_is_kept(place: &Place) -> Checked {
    let result = place.json("out/s/result.json")?;
    ensure(result["status"] == "failed" && result["fault"]["step"] == "second", &result)?;
    let steps = result["steps"].as_array().map_or(0, Vec::len);
    ensure(steps == 1 && result["steps"][0]["name"] == "first", &result)
}

fn damaged_memory() -> Checked {
    let (place, ended) = run(102)?;
    ended
        .expect(3)?
        .says(&["constraint `bad` (hostile) in step `second`", "plugin `hostile` 0.0.1 (libhostile.so) "])?;
    first_step_is_kept(&place)
}

/// The constraint in C++, whose `evaluate` throws in the second step.
fn exception() -> Checked {
    let place = Place::new()?;
    compile_cpp(&root().join("tests/tests/plugins/throwing.cpp"), &place.path("libhostile.so"), &[])?;
    fs::write(place.path("s.toml"), scenario())?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libhostile.so"])?.expect(3)?;
    ended.says(&["constraint `bad` (hostile) in step `second`", "plugin `hostile` 0.0.1 (libhostile.so) "])?;
    first_step_is_kept(&place)
}

fn ctrl_c() -> Checked {
    let place = Place::new()?;
    compile(&root().join("tests/tests/plugins/hostile.c"), &place.path("libhostile.so"), &["-DCASE=38"])?;
    fs::write(place.path("s.toml"), scenario().replace("time_limit = 0.5", "time_limit = 600"))?;
    let mut command = Command::new(program());
    command.args(["run", "s.toml", "--allow-plugin", "libhostile.so"]).current_dir(place.0.path());
    let mut child = command.env("HOME", place.0.path()).stdout(Stdio::null()).spawn()?;
    // The first step is kept as the second begins, which does not return.
    while !place.path("out/s/.wireloom/results/000001").exists() {
        std::thread::yield_now();
    }
    std::thread::sleep(Duration::from_millis(100));
    let asked = Instant::now();
    let id = child.id().to_string();
    ensure(Command::new("kill").args(["-INT", &id]).status()?.success(), "no signal")?;
    let code = child.wait()?.code();
    let took = asked.elapsed();
    ensure(code == Some(2) && took < Duration::from_secs(1), (code, took))?;
    let result = place.json("out/s/result.json")?;
    ensure(result["status"] == "interrupted" && result["fault"].is_null(), &result)?;
    ensure(result["steps"].as_array().is_some_and(|steps| steps.len() == 1), &result)?;
    // The record stays, so that it can be resumed.
    ensure(place.path("out/s/.wireloom/origin").exists(), "no record")
}

fn flipping_link() -> Checked {
    let place = Place::new()?;
    let source = root().join("tests/tests/plugins/hostile.c");
    let mut hashes = vec![];
    for (name, more) in [("libone.so", &["-DCASE=0"][..]), ("libtwo.so", &["-DCASE=0", "-DOTHER"])] {
        compile(&source, &place.path(name), more)?;
        hashes.push(wireloom::export::sha256(&fs::read(place.path(name))?));
    }
    let (link, spare) = (place.path("libhostile.so"), place.path("spare"));
    let flip = |to: &str| {
        let _ = std::os::unix::fs::symlink(place.path(to), &spare);
        fs::rename(&spare, &link)
    };
    flip("libone.so")?;
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                let _ = flip("libtwo.so").and_then(|()| flip("libone.so"));
            }
        });
        let load = || -> Checked {
            for _ in 0..2000 {
                let mut plugins = Plugins::default();
                let plugin = plugins.load(&link, &mut wireloom::registry())?;
                let want = &hashes[usize::from(plugin.version == "0.0.2")];
                ensure(plugin.hash == *want, (&plugin.version, &plugin.hash))?;
            }
            Ok(())
        };
        let loaded = load();
        over.store(true, Ordering::Relaxed);
        loaded
    })
}

fn rounding_mode() -> Checked {
    let place = Place::new()?;
    compile(&root().join("tests/tests/plugins/liar.c"), &place.path("libliar.so"), &["-DCASE=30"])?;
    fs::write(place.path("s.toml"), scenario().replace("\"hostile\"", "\"liar\""))?;
    let ended = place.wireloom(&["run", "s.toml", "--allow-plugin", "libliar.so"])?.expect(0)?;
    ensure(ended.out.contains("(libliar.so) changed the rounding mode of the processor in `evaluate`"), &ended)?;
    let notes = place.json("out/s/result.json")?["notes"].to_string();
    ensure(notes.contains("changed the rounding mode"), notes)
}

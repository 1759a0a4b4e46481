//! Sweeps whose plugin crashes or hangs at some points.

use crate::*;
use std::process::Stdio;
use wireloom::export::table::{Column, Table, read};
use wireloom_tests::cables::{branch, connector, section};

pub fn trials() -> Vec<Named> {
    vec![
        named("a point of a sweep at which a plugin crashes or hangs is a row with its reason", rows),
        named("a point whose plugin returns no number, or an error, is not a converged row", faults),
        named("such a sweep has the same bytes on any number of threads, and after a kill that leaves nothing", bytes),
        named("a point that hangs beyond the time limit of the sweep is ended", time_limit),
        named("outputs of a plugin are columns of a sweep, equal to those of single runs, and compared", outputs),
        named("points in other processes have the bytes of points in this one", other_processes),
    ]
}

/// A cantilever with the spring at its end, over stiffnesses of 1 to 64 N/m: chains of four points.
fn scenario(plugins: &str, stiffness: &str) -> String {
    [
        &*format!("schema = 1\nname = \"trouble\"\ngravity = [0, 0, 0]\n{plugins}\n"),
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.5, 10),
        &connector("clamp", "A", [0.0, 0.0, 0.0]),
        "[[constraints]]\nname = \"bad\"\nat = { end = \"B\" }\nposition = [0.5, 0, \"10 mm\"]\n",
        stiffness,
    ]
    .concat()
}

const SPRING: &str = "kind = \"trouble\"\nstiffness = 1\n";
const SWEEP: &str = "[sweep.vary]\n\"constraints.bad.stiffness\" = { from = 1, to = 64, count = 64 }\n";

fn plugins(time_limit: f64) -> String {
    format!("[plugins]\nload = [\"trouble\"]\ntime_limit = {time_limit}")
}

/// A folder with the plugin and this scenario.
fn place(text: &str) -> Result<Place, Failed> {
    let place = Place::new()?;
    compile(&root().join("tests/tests/plugins/trouble.c"), &place.path("libtrouble.so"), &[])?;
    fs::write(place.path("s.toml"), text)?;
    Ok(place)
}

const ARGUMENTS: [&str; 5] = ["sweep", "s.toml", "--csv", "--allow-plugin", "libtrouble.so"];

fn table(place: &Place, out: &str) -> Result<Table, Failed> {
    Ok(read(fs::read(place.path(out).join("points.parquet"))?)?)
}

fn words(table: &Table, name: &str) -> Vec<String> {
    table.words(name).iter().map(|word| word.clone().unwrap_or_default()).collect()
}

fn rows() -> Checked {
    let place = place(&scenario(&plugins(0.5), &[SPRING, SWEEP].concat()))?;
    let ended = place.wireloom(&ARGUMENTS)?.expect(0)?;
    ensure(ended.out.contains("64 points: 59 converged, 4 crashed, 1 time limit"), &ended)?;
    // What the plugin prints is passed on.
    ensure(ended.err.contains("a line and a half\n") && !ended.err.contains("@wireloom"), &ended)?;
    let table = table(&place, "out/s")?;
    let hash = wireloom::export::sha256(&fs::read(place.path("libtrouble.so"))?);
    let line = format!("plugin `trouble` 0.0.1 from libtrouble.so (SHA-256 {hash})");
    ensure(table.note("wireloom.plugins") == Some(line.as_str()), &table.notes)?;
    let (status, message) = (words(&table, "status"), words(&table, "message"));
    let plugin = "constraint `bad` (trouble): plugin `trouble` 0.0.1 (libtrouble.so)";
    let troubles = [
        (7, "crashed", format!("{plugin} crashed: invalid memory access (SIGSEGV) (in `evaluate`)")),
        (20, "time limit", format!("{plugin} did not return within 0.5 s (in `evaluate`)")),
        (21, "crashed", format!("{plugin} aborted the process (SIGABRT) (in `evaluate`)")),
        (40, "crashed", format!("{plugin} ended the process (exit) (in `evaluate`)")),
        (45, "crashed", "the process that computed it ended with SIGKILL".to_owned()),
    ];
    let Some(Column::Numbers(stiffness)) = table.column("constraints.bad.stiffness") else {
        return Err("no column of stiffnesses".into());
    };
    let (force, pull) = (table.numbers("force_z.bad"), table.numbers("force_x.bad"));
    for k in 0..64 {
        match troubles.iter().find(|(n, ..)| *n == k + 1) {
            Some((_, is, reason)) => {
                ensure(status[k] == *is && message[k] == *reason && force[k].is_none(), (k, &status[k], &message[k]))?;
            }
            None => {
                ensure(status[k] == "converged" && message[k].is_empty(), (k, &status[k], &message[k]))?;
                // Two springs in a row: the plugin's, and a cantilever under the tension T that comes from its
                // deflection, 3 E I / L³ + 6 T / 5 L (Timoshenko & Gere 1961); ten segments.
                let cantilever = 0.24 + 1.2 * pull[k].unwrap_or(0.0) / 0.5;
                let stiffness = stiffness[k].unwrap_or(0.0);
                near("force", force[k].unwrap_or(0.0), 0.01 / (1.0 / stiffness + 1.0 / cantilever), 3e-3)?;
            }
        }
    }
    Ok(())
}

fn faults() -> Checked {
    let vary = "[sweep.vary]\n\"constraints.bad.stiffness\" = { values = [99, 100, 101, 102] }\n";
    let place = place(&scenario(&plugins(0.5), &[SPRING, vary].concat()))?;
    let ended = place.wireloom(&ARGUMENTS)?.expect(0)?;
    // The error comes as the scenario is built: that is a refusal.
    ensure(ended.out.contains("4 points: 2 converged, 1 failed, 1 refused"), &ended)?;
    let table = table(&place, "out/s")?;
    let (status, message) = (words(&table, "status"), words(&table, "message"));
    ensure(status == ["converged", "failed", "refused", "converged"], &status)?;
    ensure(message[1].contains("returned NaN as energy") && message[2].contains("failed in `evaluate`"), &message)
}

/// The sweep in this folder on so many threads.
fn sweep(place: &Place, out: &str, threads: usize) -> Command {
    let mut command = Command::new(program());
    command.args(ARGUMENTS).args(["--quiet", "--out"]).arg(place.path(out)).current_dir(place.0.path());
    command.env("RAYON_NUM_THREADS", threads.to_string()).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn bytes() -> Checked {
    let place = place(&scenario(&plugins(0.5), &[SPRING, SWEEP].concat()))?;
    for (out, threads) in [("one", 1), ("three", 3)] {
        ensure(sweep(&place, out, threads).status()?.success(), out)?;
    }
    // Killed as it waits for the point that hangs: four chains are done before it.
    let blocks = || fs::read_dir(place.path("killed/.wireloom/sweep")).map_or(0, |entries| entries.count());
    let mut child = sweep(&place, "killed", 1).spawn()?;
    while blocks() < 5 && child.try_wait()?.is_none() {
        std::thread::yield_now();
    }
    child.kill()?;
    child.wait()?;
    ensure(blocks() >= 5 && !place.path("killed/points.csv").exists(), "it was over before it was killed")?;
    // Its processes end by themselves, also one within a call that does not return: with it the test would not end.
    #[cfg(target_os = "linux")]
    while running_in(place.0.path())? {
        std::thread::yield_now();
    }
    ensure(sweep(&place, "killed", 2).status()?.success(), "resumed")?;
    for name in ["points.csv", "points.parquet"] {
        let of = |out: &str| fs::read(place.path(out).join(name));
        ensure(of("one")? == of("three")? && of("one")? == of("killed")?, name)?;
    }
    Ok(())
}

/// Whether a process works in this folder.
#[cfg(target_os = "linux")]
fn running_in(folder: &Path) -> Result<bool, Failed> {
    let folder = folder.canonicalize()?;
    // Processes of others cannot be looked into, and some end meanwhile.
    Ok(fs::read_dir("/proc")?
        .flatten()
        .any(|entry| fs::read_link(entry.path().join("cwd")).is_ok_and(|at| at == folder)))
}

fn time_limit() -> Checked {
    let vary = "[sweep]\ntime_limit = 0.5\n[sweep.vary]\n\"constraints.bad.stiffness\" = { values = [19, 20, 22] }\n";
    let place = place(&scenario(&plugins(600.0), &[SPRING, vary].concat()))?;
    let ended = place.wireloom(&ARGUMENTS)?.expect(0)?;
    ensure(ended.out.contains("3 points: 2 converged, 1 time limit"), &ended)?;
    let message = &words(&table(&place, "out/s")?, "message")[1];
    ensure(message.starts_with("not done within 0.5 s: its process was ended"), message)
}

/// Columns of the strap: at the end and the greatest value over all increments.
const OUTPUTS: &str = r#"
[sweep.vary]
"constraints.strap.stiffness" = { values = ["0.1 N/m", "0.5 N/m"] }
[sweep.outputs]
pull = { quantity = "output", of = { constraint = "strap", output = "tension" } }
most = { quantity = "output", of = { constraint = "strap", output = "elongation" }, at = "max" }
"#;

fn outputs() -> Checked {
    let place = Place::new()?;
    strap(place.0.path())?;
    let text = fs::read_to_string(root().join("plugins/elastic-strap/elastic-strap.toml"))? + OUTPUTS;
    fs::write(place.path("s.toml"), &text)?;
    let allowed = ["--allow-plugin", "libelastic_strap.so"];
    place.wireloom(&[&["sweep", "s.toml"], &allowed[..]].concat())?.expect(0)?;
    let table = table(&place, "out/s")?;
    let mut ends = vec![];
    for k in ["0", "1"] {
        let run = ["run", "s.toml", "--point", k, "--out", k];
        let ended = place.wireloom(&[&run, &allowed[..]].concat())?.expect(0)?;
        ensure(ended.out.contains("tension") && ended.out.contains("elongation"), &ended)?;
        let steps = place.json(&format!("{k}/result.json"))?["steps"].clone();
        let last = steps.as_array().and_then(|steps| steps.last()).cloned().unwrap_or_default();
        ends.push(["tension", "elongation"].map(|name| number(&last, &format!("/constraints/strap/outputs/{name}"))));
    }
    let pull = [Some(ends[0][0]), Some(ends[1][0])];
    ensure(table.numbers("output.pull") == pull && ends[0][0] != ends[1][0], (&table.columns, &ends))?;
    for (most, end) in table.numbers("output.most").iter().zip(&ends) {
        ensure(most.is_some_and(|most| most >= end[1]), (most, end))?;
    }
    let compared = place.wireloom(&["compare", "0", "1", "--json"])?.expect(0)?;
    let compared: Value = serde_json::from_str(&compared.out)?;
    let difference = number(&compared, "/differences/1/constraints/strap/outputs/tension");
    ensure(difference == ends[1][0] - ends[0][0], &compared)?;
    let shown = place.wireloom(&["compare", "0", "1"])?.expect(0)?;
    ensure(shown.out.contains("output [SI]") && shown.out.contains("tension"), &shown)?;
    fs::write(place.path("s.toml"), text.replace("output = \"tension\"", "output = \"tensoin\""))?;
    let refused = place.wireloom(&[&["sweep", "s.toml"], &allowed[..]].concat())?.expect(1)?;
    refused.says(&["constraint \"strap\" has no output \"tensoin\"", "tension"])
}

fn other_processes() -> Checked {
    let handle = "kind = \"handle\"\nstiffness = 1\n";
    let text = |plugins: &str| scenario(plugins, &[handle, "[sweep]\nswept = \"20 mm\"\n", SWEEP].concat());
    let files = |text: &str| -> Result<[Vec<u8>; 2], Failed> {
        let place = place(text)?;
        place.wireloom(&ARGUMENTS)?.expect(0)?;
        Ok([fs::read(place.path("out/s/points.csv"))?, fs::read(place.path("out/s/swept.glb"))?])
    };
    ensure(files(&text(&plugins(10.0)))? == files(&text(""))?, "the files differ")
}

//! Sweeps: failing points, interruptions, warm starts, and the table as other programs read it.

use libtest_mimic::{Arguments, Failed, Trial};
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::sync::Mutex;
use wireloom::Control;
use wireloom::export::table::{Column, Row, Table, read};
use wireloom::scenario::{NoFiles, Setting};
use wireloom::session::Monitor;
use wireloom::sweep::{Points, header};
use wireloom_tests::cables::hanging;
use wireloom_tests::{program, root};

type Checked = Result<(), Failed>;
type Check = fn() -> Checked;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let own: [(&str, Check); 7] = [
        ("killed ten times and taken up again, it has the same bytes as one of one thread that was left alone", killed),
        ("points that fail are rows, those beside them are not touched, and the report tells of both", failing_points),
        ("a scenario that changes begins anew, one without a sweep is refused", other_scenarios),
        ("a refused sweep names its keys", refused),
        ("a start from a neighbour leads to what one afresh leads to, by a shorter way", from_neighbours),
        ("where it would lead to another equilibrium, points are started afresh", hysteresis),
        ("columns that a sweep asks for say what is there", outputs),
    ];
    let mut trials: Vec<Trial> = own.into_iter().map(|(name, check)| Trial::test(name, check)).collect();
    let python = python();
    let reason =
        if python.is_some() { "" } else { " (ignored: no python3, or the one WIRELOOM_PYTHON names, with duckdb)" };
    let trial = Trial::test(format!("DuckDB reads the table{reason}"), || duckdb(&self::python().unwrap_or_default()));
    trials.push(trial.with_ignored_flag(python.is_none()));
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn ensure(holds: bool, otherwise: impl std::fmt::Debug) -> Checked {
    if holds { Ok(()) } else { Err(format!("{otherwise:#?}").into()) }
}

/// A cable of a few segments between two plugs, over these values.
fn cable(sweep: &str) -> String {
    hanging("cable", 12, &format!("[sweep]\n{sweep}\n"))
}

fn sweep(folder: &Path, out: &str) -> Command {
    let mut command = Command::new(program());
    command.args(["sweep", "s.toml", "--out", out]).current_dir(folder);
    command
}

fn table(folder: &Path) -> Result<Table, Failed> {
    Ok(read(fs::read(folder.join("points.parquet"))?)?)
}

fn numbers<'a>(table: &'a Table, name: &str) -> Result<&'a [Option<f64>], Failed> {
    match table.column(name) {
        Some(Column::Numbers(numbers)) => Ok(numbers),
        other => Err(format!("{name}: {other:?}").into()),
    }
}

fn words<'a>(table: &'a Table, name: &str) -> Result<Vec<&'a str>, Failed> {
    match table.column(name) {
        Some(Column::Words(words)) => Ok(words.iter().map(|word| word.as_deref().unwrap_or_default()).collect()),
        other => Err(format!("{name}: {other:?}").into()),
    }
}

const MANY: &str = r#"
method = "latin-hypercube"
samples = 1500
seed = 5
[sweep.vary]
"branches.cable.length" = { mean = "1 m", deviation = "20 mm" }
"constraints.plug-B.position.0" = { from = 0.5, to = 0.7 }
"sections.cable.bending_stiffness" = { values = [0.01, "12000 N mm^2"] }
"#;

/// Blocks that are done.
fn blocks(folder: &Path) -> usize {
    fs::read_dir(folder.join(".wireloom/sweep")).map_or(0, |entries| entries.count())
}

fn killed() -> Checked {
    let place = tempfile::tempdir()?;
    fs::write(place.path().join("s.toml"), cable(MANY))?;
    let left_alone = sweep(place.path(), "alone").arg("--quiet").env("RAYON_NUM_THREADS", "1").status()?;
    ensure(left_alone.success(), left_alone)?;
    let folder = place.path().join("killed");
    for _ in 0..10 {
        let before = blocks(&folder);
        let mut child = sweep(place.path(), "killed").stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
        // At some time after the next block is done.
        while blocks(&folder) <= before + 1 && child.try_wait()?.is_none() {
            std::thread::yield_now();
        }
        child.kill()?;
        child.wait()?;
    }
    ensure(blocks(&folder) > 5 && !folder.join("points.parquet").exists(), "it was over before it was killed")?;
    let last = sweep(place.path(), "killed").output()?;
    let said = String::from_utf8_lossy(&last.stdout).into_owned();
    ensure(last.status.success() && said.starts_with("going on after "), &said)?;
    ensure(said.contains("1500 points: 1500 converged"), &said)?;
    let bytes = |name: &str| fs::read(place.path().join(name).join("points.parquet"));
    ensure(bytes("alone")? == bytes("killed")?, "the tables differ")?;
    ensure(blocks(&folder) == 0, "blocks are left behind")
}

fn failing_points() -> Checked {
    let place = tempfile::tempdir()?;
    let grid = r#"
[sweep.vary]
"branches.cable.length" = { values = ["1 m", -1, 1.2] }
"name" = { values = ["x", "y"] }
"#;
    fs::write(place.path().join("s.toml"), cable(grid))?;
    let ended = sweep(place.path(), "o").output()?;
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    ensure(ended.status.success() && said.contains("6 points: 4 converged, 2 refused"), &said)?;
    let table = table(&place.path().join("o"))?;
    let status = words(&table, "status")?;
    ensure(status == ["converged", "converged", "refused", "refused", "converged", "converged"], &status)?;
    ensure(words(&table, "name")? == ["x", "y", "x", "y", "x", "y"], &table.columns[2])?;
    ensure(words(&table, "message")?[2].contains("`length` = -1 is too small"), words(&table, "message")?)?;
    let lengths = numbers(&table, "branches.cable.length")?;
    ensure(lengths == [1.0, 1.0, -1.0, -1.0, 1.2, 1.2].map(Some), lengths)?;
    let energy = numbers(&table, "energy.total")?;
    ensure(energy[2].is_none() && energy[0].is_some() && energy[0] == energy[1] && energy[0] != energy[4], energy)?;
    // A longer cable is a heavier one: what both plugs bear is its weight.
    let force = |name: &str| numbers(&table, name).map(|forces| forces[4].unwrap_or(0.0));
    let borne = force("force_z.plug-A")? + force("force_z.plug-B")?;
    ensure((borne - 1.2 * 0.05 * 9.81).abs() < 1e-4, borne)?;
    // A point can be carried out by itself, and comes to the same.
    let run = |point: &str| {
        Command::new(program())
            .args(["run", "s.toml", "--out", "p", "--point", point])
            .current_dir(place.path())
            .output()
    };
    let ended = run("4")?;
    ensure(ended.status.success(), &ended)?;
    let result: serde_json::Value = serde_json::from_slice(&fs::read(place.path().join("p/result.json"))?)?;
    ensure(result["steps"][0]["energy"]["total"].as_f64() == energy[4], &result["steps"][0]["energy"])?;
    let provenance = &result["provenance"];
    ensure(
        provenance["set"][0] == "branches.cable.length = 1.2" && provenance["minimiser"]["kind"] == "newton",
        provenance,
    )?;
    ensure(provenance["files"]["s.toml"].as_str().is_some_and(|hash| hash.len() == 64), provenance)?;
    let ended = run("6")?;
    ensure(String::from_utf8_lossy(&ended.stderr).contains("the sweep has points 0 to 5"), &ended)?;
    let ended = Command::new(program()).args(["report", "o"]).current_dir(place.path()).output()?;
    ensure(ended.status.success(), &ended)?;
    let page = fs::read_to_string(place.path().join("o/report.html"))?;
    ensure(page.contains("cable: 6 points") && page.contains("is too small") && page.contains("<svg"), &page)?;
    fs::write(place.path().join("o/points.parquet"), "PAR1")?;
    let ended = Command::new(program()).args(["report", "o"]).current_dir(place.path()).output()?;
    ensure(ended.status.code() == Some(1), &ended)
}

fn other_scenarios() -> Checked {
    let place = tempfile::tempdir()?;
    let write = |count: usize| {
        let range = format!("{{ from = \"900 mm\", to = \"1100 mm\", count = {count} }}");
        fs::write(place.path().join("s.toml"), cable(&format!("[sweep.vary]\n\"branches.cable.length\" = {range}")))
    };
    for count in [3, 5] {
        write(count)?;
        let ended = sweep(place.path(), "o").output()?;
        let said = String::from_utf8_lossy(&ended.stdout).into_owned();
        ensure(said.starts_with(&format!("{count} points: {count} converged")), &said)?;
    }
    fs::write(place.path().join("s.toml"), cable("").replace("[sweep]", ""))?;
    let ended = sweep(place.path(), "o").output()?;
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    ensure(ended.status.code() == Some(1) && said.contains("s.toml has no [sweep]"), &said)
}

fn refused() -> Checked {
    let place = tempfile::tempdir()?;
    let grid = "[sweep.vary]\n\"branches.cabel.length\" = { values = [1] }\n";
    fs::write(place.path().join("s.toml"), cable(grid))?;
    let ended = sweep(place.path(), "o").output()?;
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    ensure(ended.status.code() == Some(1), &said)?;
    ensure(said.contains("at the first point of the sweep: there is no entry `cabel`"), &said)?;
    ensure(said.contains("did you mean `cable`?") && said.starts_with("s.toml:"), &said)
}

/// Energy (J) and iterations.
type Ended = (f64, f64);

/// The rows of a sweep, and how a run of each point alone ends.
fn rows_and_runs(text: &str) -> Result<(Vec<Row>, Vec<Ended>), Failed> {
    let registry = wireloom::registry();
    let load = |settings: &[Setting]| {
        let loaded = wireloom::load_with_settings(text, settings, &NoFiles, &registry);
        loaded.map_err(|faults| Failed::from(wireloom::scenario::render(text, &faults)))
    };
    let (scenario, built) = load(&[])?;
    let sweep = scenario.sweep.as_ref().ok_or("no sweep")?;
    let header = header(sweep, &built.network);
    let points = Points { text, files: &NoFiles, minimiser: None, registry: &registry, batch: None, sweep, header };
    let chains = points.chains();
    let kept = Mutex::new(vec![Vec::new(); chains.len()]);
    points.compute(&(0..chains.len()).collect::<Vec<_>>(), &Monitor::default(), &|| (), |k, rows| {
        kept.lock().map_err(|_| "poisoned")?[k] = rows;
        Ok::<(), &str>(())
    })?;
    let rows: Vec<Row> = kept.into_inner()?.into_iter().flatten().collect();
    ensure(rows.len() == sweep.points, rows.len())?;
    let mut runs = Vec::new();
    for k in 0..sweep.points {
        let run = wireloom::run(load(&sweep.settings(k))?.1, &mut |_, _| Control::Continue);
        let end = run.steps.last().ok_or("nothing was computed")?;
        runs.push((end.energy.total(), end.minimiser.iterations as f64));
    }
    Ok((rows, runs))
}

/// Energy and iterations of a row.
fn energy_and_iterations(row: &Row) -> Ended {
    (row.numbers[2].unwrap_or(f64::NAN), row.numbers[0].unwrap_or(f64::NAN))
}

fn from_neighbours() -> Checked {
    let text = fs::read_to_string(root().join("scenarios/sweeps/y_tolerances.toml"))?;
    let (rows, runs) = rows_and_runs(&text)?;
    let mut shorter = 0;
    for (row, (energy, iterations)) in rows.iter().zip(&runs) {
        ensure(row.status == "converged" && row.stable == Some(true), row)?;
        let (found, spent) = energy_and_iterations(row);
        ensure((found - energy).abs() <= 1e-8 * energy.abs(), (row, energy))?;
        shorter += usize::from(4.0 * spent < *iterations);
    }
    // Chains of 16 points: all but both ends.
    ensure(shorter == 256 / 16 * 14, shorter)
}

/// A strip pressed together hangs down or stands up in an arch, as gravity points; once it does, it would go on doing
/// so for a while where gravity has turned around.
fn hysteresis() -> Checked {
    let gravity = "[sweep.vary]\n\"gravity.2\" = { from = -3, to = 3.12, count = 128 }\n";
    let text = cable(gravity)
        .replace("[0.6, 0.0, 0.0]", "[0.9, 0, 0]")
        .replace("bending_stiffness = 0.01", "bending_stiffness = [0.1, 0.01]")
        .replace("schema = 1", "schema = 1\ngravity = [0, 0, -9.81]");
    let (rows, runs) = rows_and_runs(&text)?;
    let mut shorter = 0;
    for (row, (energy, iterations)) in rows.iter().zip(&runs) {
        let (found, spent) = energy_and_iterations(row);
        ensure((found - energy).abs() <= 1e-8 * energy.abs(), (row, energy))?;
        shorter += usize::from(spent < *iterations);
    }
    // The strip turns over between points 62 and 63. They are in the chain of points 56 to 63, all of which have to be
    // started afresh.
    let afresh = |k: usize| energy_and_iterations(&rows[k]) == runs[k];
    let falls = |k: usize| runs[k].0 > runs[k + 1].0;
    ensure(!falls(61) && falls(62) && (56..64).all(afresh), &runs[56..64])?;
    // All but the ends of the other chains, of 8 points each, are not.
    ensure(shorter == 15 * 6, shorter)
}

fn outputs() -> Checked {
    let place = tempfile::tempdir()?;
    let grid = r#"
[sweep.vary]
"branches.cable.length" = { values = ["1 m", 1.2] }
[sweep.outputs]
end = { quantity = "position", at = { end = "B" } }
middle = { quantity = "position", at = { branch = "cable", s = "0.5 m" } }
start = { quantity = "force", at = { end = "A" } }
clamp = { quantity = "moment", at = { end = "A" } }
lowest = { quantity = "tension", at = { branch = "cable", s = 0.5 } }
beginning = { quantity = "bend-radius", span = { branch = "cable", to = 0.2 } }
whole = { quantity = "slack", span = { branch = "cable" } }
half = { quantity = "slack", span = { branch = "cable", from = 0.5 } }
"#;
    fs::write(place.path().join("s.toml"), cable(grid))?;
    let ended = sweep(place.path(), "o").output()?;
    ensure(ended.status.success(), &ended)?;
    let table = table(&place.path().join("o"))?;
    let at = |name: &str| Ok::<f64, Failed>(numbers(&table, name)?[0].unwrap_or(f64::NAN));
    let near = |a: f64, b: f64, by: f64| ensure((a - b).abs() <= by, (a, b));
    near(at("position_x.end")?, 0.6, 1e-12)?;
    near(at("position_x.middle")?, 0.3, 1e-6)?;
    let whole = numbers(&table, "slack.whole")?;
    near(whole[0].unwrap_or(f64::NAN), 0.4, 1e-12)?;
    near(whole[1].unwrap_or(f64::NAN), 0.6, 1e-12)?;
    let (dx, dz) = (at("position_x.middle")? - 0.6, at("position_z.middle")?);
    near(at("slack.half")?, 0.5 - dx.hypot(dz), 1e-9)?;
    // What the constraint bears is what the cable exerts there, but for the weight of half a segment.
    for axis in ["x", "y", "z"] {
        near(at(&format!("force_{axis}.start"))?, -at(&format!("force_{axis}.plug-A"))?, 0.05 * 9.81 / 24.0 + 1e-6)?;
        near(at(&format!("moment_{axis}.clamp"))?, -at(&format!("moment_{axis}.plug-A"))?, 1e-3)?;
    }
    // In the middle it is level: all of the force there is along it, and that is the horizontal force everywhere.
    near(at("tension.lowest")?, at("force_x.start")?, 1e-4)?;
    ensure(at("bend_radius.beginning")? > at("bend_radius")? && at("bend_radius.beginning")? < 1.0, at("bend_radius"))?;
    // A place outside one of the branches is a fault of those points alone.
    let grid = grid.replace("s = \"0.5 m\"", "s = 1.1");
    fs::write(
        place.path().join("s.toml"),
        cable(&grid).replace("length = 1.0\n", "length = 1.2\n").replace("\"1 m\", 1.2", "1.2, 1"),
    )?;
    let ended = sweep(place.path(), "o").output()?;
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    ensure(said.contains("2 points: 1 converged, 1 refused"), &ended)?;
    ensure(said.contains("`s` = 1.1 m is outside branch \"cable\""), &said)
}

/// A Python that knows DuckDB.
fn python() -> Option<String> {
    let python = std::env::var("WIRELOOM_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut try_it = Command::new(&python);
    try_it.args(["-c", "import duckdb"]).stdout(Stdio::null()).stderr(Stdio::null());
    try_it.status().is_ok_and(|status| status.success()).then_some(python)
}

fn duckdb(python: &str) -> Checked {
    let place = tempfile::tempdir()?;
    fs::copy(root().join("scenarios/sweeps/y_tolerances.toml"), place.path().join("s.toml"))?;
    ensure(sweep(place.path(), "o").arg("--quiet").status()?.success(), "the sweep fails")?;
    let query = "import duckdb\nprint(duckdb.sql(\"\"\"select count(*), count(message), avg(\"energy.total\"), \
                 min(\"branches.left.length\") from 'o/points.parquet' where status = 'converged' and \
                 stable\"\"\").fetchall()[0])";
    let output = Command::new(python).args(["-c", query]).current_dir(place.path()).output()?;
    let said = String::from_utf8(output.stdout)?;
    let table = table(&place.path().join("o"))?;
    let mean = numbers(&table, "energy.total")?.iter().flatten().sum::<f64>() / 256.0;
    let least = numbers(&table, "branches.left.length")?.iter().flatten().fold(f64::INFINITY, |a, x| a.min(*x));
    let found: Vec<f64> =
        said.trim().trim_matches(['(', ')']).split(", ").filter_map(|number| number.parse().ok()).collect();
    let expected = [256.0, 0.0, mean, least];
    let near = found.len() == 4 && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-12);
    ensure(near, (said, expected, String::from_utf8_lossy(&output.stderr)))
}

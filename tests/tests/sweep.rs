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
use wireloom::sweep::tubes::Stations;
use wireloom::sweep::{Chain, Points, Tube, header};
use wireloom_tests::cables::{built, hanging};
use wireloom_tests::{program, root};

type Checked = Result<(), Failed>;
type Check = fn() -> Checked;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let own: [(&str, Check); 15] = [
        ("killed ten times and taken up again, it has the same bytes as one of one thread that was left alone", killed),
        ("points that fail are rows, those beside them are not touched, and the report tells of both", failing_points),
        ("a scenario that changes begins anew, one without a sweep is refused", other_scenarios),
        ("a refused sweep names its keys", refused),
        ("a start from a neighbour leads to what one afresh leads to, by a shorter way", from_neighbours),
        ("where it would lead to another equilibrium, points are started afresh", hysteresis),
        ("a requirement that the start fails does not make all points start afresh", failing_starts),
        ("columns that a sweep asks for say what is there", outputs),
        ("columns over increments, and the lines of the sheet, are those of single runs", over_increments),
        ("keys of one joint model vary with that model only, crossed with samples", crossed),
        ("a point that takes too long is a row with its reason", time_limit),
        ("a point at which the program panics is a row with its reason", crashing),
        ("the swept space of a sweep has what each run sweeps in it", swept),
        ("tubes of cables that are shifted over a known range have the percentiles of that range", tubes),
        ("tubes are thicker only where the cable is", tubes_of_parts),
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
swept = "40 mm"
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
    for file in ["points.parquet", "swept.glb", "swept-tubes.glb"] {
        let bytes = |name: &str| fs::read(place.path().join(name).join(file));
        ensure(bytes("alone")? == bytes("killed")?, format!("{file} differs"))?;
    }
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

/// The chains of a sweep, and the stations of its tubes.
fn chains(text: &str) -> Result<(Vec<Chain>, Stations), Failed> {
    let registry = wireloom::registry();
    let loaded = wireloom::load(text, &registry);
    let (scenario, built) = loaded.map_err(|faults| Failed::from(wireloom::scenario::render(text, &faults)))?;
    let sweep = scenario.sweep.as_ref().ok_or("no sweep")?;
    let header = header(sweep, &built.network);
    let stations = Stations::of(&built.network, &built.schedule);
    let (files, minimiser, registry) = (&NoFiles, None, &registry);
    let points = Points { text, files, minimiser, registry, batch: None, sweep, header, stations: stations.clone() };
    let count = points.chain_count();
    let kept = Mutex::new((0..count).map(|_| None).collect::<Vec<_>>());
    points.compute(&(0..count).collect::<Vec<_>>(), &Monitor::default(), &|| (), |k, chain| {
        kept.lock().map_err(|_| "poisoned")?[k] = Some(chain);
        Ok::<(), &str>(())
    })?;
    Ok((kept.into_inner()?.into_iter().flatten().collect(), stations))
}

/// The rows of a sweep, and how a run of each point alone ends.
fn rows_and_runs(text: &str) -> Result<(Vec<Row>, Vec<Ended>), Failed> {
    let registry = wireloom::registry();
    let load = |settings: &[Setting]| {
        let loaded = wireloom::load_with_settings(text, settings, &NoFiles, &registry);
        loaded.map_err(|faults| Failed::from(wireloom::scenario::render(text, &faults)))
    };
    let (scenario, _) = load(&[])?;
    let sweep = scenario.sweep.as_ref().ok_or("no sweep")?;
    let rows: Vec<Row> = chains(text)?.0.into_iter().flat_map(|chain| chain.rows).collect();
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

/// What the report of a run says of its start was taken for a start without balance.
fn failing_starts() -> Checked {
    let more = "[sweep.vary]\n\"sections.cable.linear_density\" = { from = 0.04, to = 0.06, count = 48 }\n\
                [[requirements]]\nname = \"gentle\"\nquantity = \"bend_radius\"\n\
                of = { branch = \"cable\" }\nmin = \"10 m\"\n\
                [[steps]]\nname = \"stay\"\n";
    let (rows, runs) = rows_and_runs(&cable("").replace("[sweep]\n", &format!("[sweep]\n{more}")))?;
    let shorter = |(row, (_, iterations)): &(&Row, &Ended)| energy_and_iterations(row).1 < *iterations;
    // Chains of 3 points: all but both ends.
    ensure(rows.iter().zip(&runs).filter(shorter).count() == 16, (&rows, &runs))
}

fn outputs() -> Checked {
    let place = tempfile::tempdir()?;
    let grid = r#"
[sweep.vary]
"branches.cable.length" = { values = ["1 m", 1.2] }
[sweep.outputs]
end = { quantity = "position", of = { end = "B" } }
middle = { quantity = "position", of = { branch = "cable", s = "0.5 m" } }
start = { quantity = "force", of = { end = "A" } }
clamp = { quantity = "moment", of = { end = "A" } }
lowest = { quantity = "tension", of = { branch = "cable", s = 0.5 } }
beginning = { quantity = "bend_radius", of = { branch = "cable", from = 0.05, to = 0.2 } }
whole = { quantity = "slack", of = { branch = "cable" } }
half = { quantity = "slack", of = { branch = "cable", from = 0.5 } }
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

/// A short or a long cable whose right plug goes to 0.35 m and back above a floor that it touches on the way; the bend
/// and the plug's force are worst in the middle.
const THERE_AND_BACK: &str = r#"
method = "random"
samples = 12
seed = 3
[sweep.vary]
"branches.cable.length" = { values = [0.985, 1.015] }
"sections.cable.linear_density" = { from = 0.0499, to = 0.0501 }
[sweep.outputs]
tightest = { quantity = "bend_radius", of = { branch = "cable" }, at = "min" }
at-last = { quantity = "bend_radius", of = { branch = "cable" } }
halfway = { quantity = "bend_radius", of = { branch = "cable" }, at = "in" }
plug = { quantity = "force", of = { constraint = "plug-B" }, at = "max" }
lowest = { quantity = "position", of = { branch = "cable", s = 0.5 }, at = "min" }
floor = { quantity = "contact_force", of = { obstacle = "floor" }, at = "max" }
room = { quantity = "clearance", between = [{ branch = "cable" }, { obstacle = "floor" }], at = "max" }
opening = { quantity = "angle", between = [{ end = "A" }, { end = "B" }], at = "end" }
[[obstacles]]
name = "floor"
shape = "plane"
point = [0, 0, -0.39]
normal = [0, 0, 1]
[[steps]]
name = "in"
increments = 6
move = [{ constraint = "plug-B", position = [0.35, 0, 0] }]
[[steps]]
name = "out"
increments = 6
move = [{ constraint = "plug-B", position = [0.6, 0, 0] }]
[[requirements]]
name = "bend"
quantity = "bend_radius"
of = { branch = "cable" }
min = "50 mm"
[[requirements]]
name = "plug"
quantity = "force"
of = { constraint = "plug-B" }
max = "100 N"
"#;

fn over_increments() -> Checked {
    let place = tempfile::tempdir()?;
    // Twelve segments are too coarse. Stiff sideways, it does not fall over on the floor.
    let fine = |text: String| text.replace("segments = 12", "segments = 160");
    let stiff = |text: String| {
        text.replace("bending_stiffness = 0.01\n", "bending_stiffness = [1.0, 0.01]\n")
            .replace("torsion_stiffness = 0.008", "torsion_stiffness = 0.8")
    };
    // A limit that the long cables keep.
    let text = |limit: &str| stiff(fine(cable(&THERE_AND_BACK.replace("50 mm", limit))));
    fs::write(place.path().join("s.toml"), text("50 mm"))?;
    ensure(sweep(place.path(), "o").arg("--quiet").status()?.success(), "the sweep fails")?;
    let first = table(&place.path().join("o"))?;
    let worst: Vec<f64> = numbers(&first, "worst.bend")?.iter().flatten().copied().collect();
    let [least, most] = [f64::min, f64::max].map(|end| worst.iter().copied().reduce(end).unwrap_or(f64::NAN));
    fs::write(place.path().join("s.toml"), text(&format!("{} m", 0.5 * (least + most))))?;
    let ended = sweep(place.path(), "o").arg("--csv").output()?;
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    ensure(ended.status.success() && said.contains("12 points: 12 converged"), &ended)?;
    let long = numbers(&first, "branches.cable.length")?.iter().filter(|length| **length == Some(1.015)).count();
    ensure(said.contains(&format!("{long} pass, {} fail, 0 unresolved", 12 - long)), &said)?;
    let (low, high) = wireloom::export::table::statistics::wilson(long, 12);
    let interval = format!("{:.1} % to {:.1} %", 100.0 * low, 100.0 * high);
    ensure(said.contains(&format!("with 95 % confidence {interval}")), &said)?;
    ensure(said.contains("branches.cable.length (+"), &said)?;
    let table = table(&place.path().join("o"))?;
    let at = |name: &str, k: usize| Ok::<f64, Failed>(numbers(&table, name)?[k].unwrap_or(f64::NAN));
    let (verdicts, fails) = (words(&table, "verdict")?, words(&table, "fails")?);
    let text = fs::read_to_string(place.path().join("s.toml"))? + "\n[output]\nincrements = true\n";
    for k in [0, 7] {
        let registry = wireloom::registry();
        let (scenario, _) = wireloom::load(&text, &registry).map_err(|faults| format!("{faults:?}"))?;
        let settings = scenario.sweep.ok_or("no sweep")?.settings(k);
        let loaded = wireloom::load_with_settings(&text, &settings, &NoFiles, &registry);
        let run = wireloom::run(loaded.map_err(|faults| format!("{faults:?}"))?.1, &mut |_, _| Control::Continue);
        ensure(run.steps.len() == 12, run.steps.len())?;
        let near = |column: &str, expected: f64| {
            let found = at(column, k)?;
            // The start may be a warm one.
            ensure((found - expected).abs() <= 1e-5 * expected.abs().max(1e-3), (column, found, expected))
        };
        let radius =
            |step: &wireloom::StepResult| step.branches[0].bend_radius.iter().copied().fold(f64::INFINITY, f64::min);
        let least = run.steps.iter().map(radius).fold(f64::INFINITY, f64::min);
        let plug = |step: &wireloom::StepResult| step.constraints[1].force.norm();
        let floor = run.steps.iter().map(|step| step.obstacles[0].contact_force).fold(0.0, f64::max);
        ensure(least < 0.9 * radius(&run.steps[11]) && floor > 0.1, (least, floor))?;
        near("bend_radius.tightest", least)?;
        near("min_bend_radius", least)?;
        near("bend_radius.at-last", radius(&run.steps[11]))?;
        near("bend_radius.halfway", radius(&run.steps[5]))?;
        near("force.plug", run.steps.iter().map(plug).fold(0.0, f64::max))?;
        near("contact_force.floor", floor)?;
        let lowest =
            |step: &wireloom::StepResult| step.branches[0].position.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
        let (found, expected) = (at("position_z.lowest", k)?, run.steps.iter().map(lowest).fold(0.0, f64::min));
        ensure((found - expected).abs() < 2e-3, (found, expected))?;
        near("angle.opening", 0.0)?;
        let room = run.steps.iter().map(|step| lowest(step) + 0.39 - 0.003);
        let (found, expected) = (at("clearance.room", k)?, room.fold(f64::NEG_INFINITY, f64::max));
        ensure((found - expected).abs() < 1e-5, (found, expected))?;
        let line = run.requirements.iter().find(|line| line.name == "bend").ok_or("no line")?;
        near("worst.bend", line.worst.unwrap_or(f64::NAN))?;
        near("margin.bend", line.margin().unwrap_or(f64::NAN))?;
        ensure(words(&table, "verdict.bend")?[k] == line.verdict.word(), (&verdicts, line))?;
        ensure(verdicts[k] == run.verdict().word(), (&verdicts, line))?;
        ensure((verdicts[k] == "fail") == fails[k].contains("bend"), &fails)?;
        let moment = line.moment.as_ref().ok_or("no moment")?;
        ensure(words(&table, "step.bend")?[k] == moment.step, moment)?;
    }
    let csv = fs::read_to_string(place.path().join("o/points.csv"))?;
    ensure(csv.lines().count() == 13 && csv.starts_with("point,branches.cable.length,"), &csv)?;
    // The page shows it first, and how to see the worst point.
    ensure(Command::new(program()).args(["report", "o"]).current_dir(place.path()).status()?.success(), "no page")?;
    let page = fs::read_to_string(place.path().join("o/report.html"))?;
    let [verdict, region, results] = ["id=\"verdicts\"", "id=\"region\"", "id=\"results\""].map(|id| page.find(id));
    ensure(verdict.is_some() && verdict < region && region < results, (verdict, region, results))?;
    ensure(page.contains(&format!("{long} pass")) && page.contains(&interval) && page.contains("--point "), "no yield")
}

fn crossed() -> Checked {
    let place = tempfile::tempdir()?;
    let text = fs::read_to_string(root().join("scenarios/sweeps/y_tolerances.toml"))?;
    let text = text.replace("samples = 256", "samples = 4").replace("min_bend_radius = \"48 mm\"", "").replace(
        "[sweep.outputs]",
        "[sweep.cross]\n\"joints.J.model\" = { values = [\"cosserat\", \"rigid-body\"] }\n\
         \"joints.J.mass\" = { values = [0, 0.05], when = { \"joints.J.model\" = \"rigid-body\" } }\n[sweep.outputs]",
    );
    fs::write(place.path().join("s.toml"), &text)?;
    let ended = sweep(place.path(), "o").output()?;
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    ensure(ended.status.success() && said.contains("12 points: 12 converged"), &ended)?;
    let table = table(&place.path().join("o"))?;
    let model = words(&table, "joints.J.model")?;
    let mass = numbers(&table, "joints.J.mass")?;
    for k in 0..12 {
        let expected = [("cosserat", None), ("rigid-body", Some(0.0)), ("rigid-body", Some(0.05))][k / 4];
        ensure((model[k], mass[k]) == expected, (k, &model, mass))?;
    }
    let lengths = numbers(&table, "branches.trunk.length")?;
    ensure(lengths[..4] == lengths[4..8] && lengths[..4] == lengths[8..], lengths)?;
    let energy = numbers(&table, "energy.gravity")?;
    ensure((0..4).all(|k| energy[4 + k] != energy[8 + k]), energy)?;
    // The picture once had a key of one model as an axis, and so no point of the other.
    ensure(Command::new(program()).args(["report", "o"]).current_dir(place.path()).status()?.success(), "no page")?;
    let page = fs::read_to_string(place.path().join("o/report.html"))?;
    let (_, region) = page.split_once("id=\"region\"").ok_or("no picture")?;
    let (region, _) = region.split_once("</section>").ok_or("no end of the picture")?;
    ensure(!region.contains("joints.J.mass") && region.matches("<circle").count() == 12, region)?;
    // Conditions that mean nothing are refused.
    for (from, to, words) in [
        (
            "\"joints.J.model\" = \"rigid-body\" }",
            "\"joints.J.modl\" = \"rigid-body\" }",
            "does not vary `joints.J.modl`",
        ),
        ("= \"rigid-body\" }", "= \"fused\" }", "`joints.J.model` is never \"fused\""),
    ] {
        fs::write(place.path().join("s.toml"), text.replace(from, to))?;
        let ended = sweep(place.path(), "o").output()?;
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        ensure(ended.status.code() == Some(1) && said.contains(words), &said)?;
    }
    Ok(())
}

/// The second point has a hundred thousand times the increments of the first; none is as fast as a millisecond in 1 s.
fn time_limit() -> Checked {
    let place = tempfile::tempdir()?;
    let sweep_of_increments = "time_limit = 20\n[sweep.vary]\n\"steps.pull.increments\" = { values = [1, 100000] }\n\
         [[steps]]\nname = \"pull\"\nincrements = 1\nmove = [{ constraint = \"plug-B\", position = [0.5, 0, 0] }]\n";
    let text = cable(sweep_of_increments).replace("segments = 12", "segments = 300");
    fs::write(place.path().join("s.toml"), text)?;
    let ended = sweep(place.path(), "o").output()?;
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    ensure(ended.status.success() && said.contains("2 points: ") && said.contains("1 time limit"), &ended)?;
    let table = table(&place.path().join("o"))?;
    ensure(words(&table, "status")? == ["converged", "time limit"], &table.columns)?;
    let message = words(&table, "message")?[1];
    ensure(message.starts_with("not done within 20 s: it was ended after increment "), message)?;
    ensure(message.ends_with(" of 100000 of step `pull`"), message)
}

fn crashing() -> Checked {
    let mut registry = wireloom::registry();
    let rod = wireloom::parts::RodKind {
        name: "brittle".into(),
        doc: "a rod that breaks the program where it is long".into(),
        parameters: vec![],
        build: Box::new(|spec, _| {
            let length = spec.mesh.length();
            assert!(length < 1.1, "it broke at {length:.1} m");
            Ok(Box::new(wireloom::parts::rods::cosserat::rod(spec.clone())))
        }),
    };
    registry.add_rod(rod).map_err(|rod| rod.name)?;
    let text = cable("[sweep.vary]\n\"branches.cable.length\" = { values = [1.0, 1.2, 1.05] }\n");
    let text = text.replace("length = 1.0\n", "length = 1.0\nrod = \"brittle\"\n");
    let (_, rows) = wireloom::sweep::run(&text, &NoFiles, &registry).map_err(|faults| format!("{faults:?}"))?;
    let status: Vec<&str> = rows.iter().map(|row| row.status.as_str()).collect();
    ensure(status == ["converged", "crashed", "converged"], &status)?;
    let message = rows[1].message.as_deref().unwrap_or_default();
    ensure(message == "the program failed at this point: it broke at 1.2 m", message)?;
    ensure(rows[1].verdict.is_none() && rows[1].numbers.iter().all(Option::is_none), &rows[1])
}

/// The JSON of a GLB file.
fn glb(path: &Path) -> Result<serde_json::Value, Failed> {
    let bytes = fs::read(path)?;
    let length = u32::from_le_bytes(bytes[12..16].try_into()?) as usize;
    Ok(serde_json::from_slice(&bytes[20..20 + length])?)
}

fn tubes() -> Checked {
    // Both plugs are shifted alike, by -100 to 100 mm in steps of 1 mm: the cable keeps its shape.
    let shifted =
        "swept = \"50 mm\"\n[sweep.vary]\n\"constraints.*.position.1\" = { from = -0.1, to = 0.1, count = 201 }\n";
    let steps = "[[steps]]\nname = \"hang\"\n[[steps]]\nname = \"accelerate\"\ngravity = [0, 0, -20]\nincrements = 2\n";
    let text = cable(&[shifted, steps].concat());
    let (chains, points) = chains(&text)?;
    let all = points.tubes(chains.len(), |k| Ok::<_, Failed>(chains[k].lines.clone()))?;
    ensure(all.len() == 2 && all[0].step == "hang" && all[1].step == "accelerate", &all)?;
    let radius = 0.5 * built(&text).network.branches[0].sections.diameter();
    for tube in &all {
        ensure(tube.points == 201 && tube.centre.iter().all(|x| x.y.abs() < 1e-6), &tube.centre)?;
        let found: Vec<usize> = tube.radii.iter().map(|(percent, _)| *percent).collect();
        ensure(found == [50, 90, 95, 100], found)?;
        for ((percent, radii), shift) in tube.radii.iter().zip([0.050, 0.090, 0.095, 0.100]) {
            let off = radii.iter().map(|r| (r - shift - radius).abs()).fold(0.0, f64::max);
            ensure(off < 2e-6, format!("{percent} % of `{}`: off by {off} m", tube.step))?;
        }
    }
    // The sag differs between the steps: the mean line is that of the step.
    let sag = |tube: &Tube| tube.centre.iter().map(|x| x.z).fold(0.0, f64::min);
    ensure(sag(&all[1]) < sag(&all[0]) - 1e-5, (sag(&all[0]), sag(&all[1])))?;
    let place = tempfile::tempdir()?;
    fs::write(place.path().join("s.toml"), &text)?;
    ensure(sweep(place.path(), "o").arg("--quiet").status()?.success(), "the sweep fails")?;
    let json = glb(&place.path().join("o/swept-tubes.glb"))?;
    let nodes = json["nodes"].as_array().ok_or("no nodes")?;
    let named = |name: &str| nodes.iter().find(|node| node["name"] == name).ok_or(format!("no node `{name}`"));
    let extras = serde_json::json!({ "branch": "cable", "percentile": 95, "step": "hang", "points": 201 });
    ensure(named("cable / 95 % / hang")?["extras"] == extras, named("cable / 95 % / hang")?)?;
    let mesh = named("cable / 100 % / accelerate")?["mesh"].as_u64().ok_or("no mesh")? as usize;
    let position = json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"].as_u64().ok_or("none")? as usize;
    let width = json["accessors"][position]["max"][1].as_f64().ok_or("no bound")?;
    ensure((width - 0.1 - radius).abs() < 1e-5, width)
}

/// A cable at one place with a thicker part of 0.4 to 0.5 of its length: stations up to the next one beyond have its
/// radius, all others that of the cable.
fn tubes_of_parts() -> Checked {
    let text = cable("swept = \"50 mm\"\n[sweep.vary]\n\"constraints.*.position.1\" = { values = [0.0] }\n");
    let thick = "[sections.thick]\ndiameter = \"40 mm\"\nlinear_density = \"60 g/m\"\naxial_stiffness = 1e4\n\
                 bending_stiffness = 0.01\ntorsion_stiffness = 0.008\n";
    let part = "\nsections = [{ section = \"thick\", from = 0.4, to = 0.5 }]\nlength = ";
    let text = text.replacen("\nlength = ", part, 1).replacen("[[branches]]", &[thick, "[[branches]]"].concat(), 1);
    let (chains, points) = chains(&text)?;
    let tubes = points.tubes(chains.len(), |k| Ok::<_, Failed>(chains[k].lines.clone()))?;
    let (_, radii) = &tubes[0].radii[0];
    let pieces = (radii.len() - 1) as f64;
    let of_cable = radii[0];
    for (k, radius) in radii.iter().enumerate() {
        let place = k as f64 / pieces;
        let is_near = place > 0.4 - 1.0 / pieces && place < 0.5 + 1.0 / pieces;
        let expected = if is_near { 0.02 } else { of_cable };
        ensure((radius - expected).abs() < 1e-6, format!("{radius} m at {place}"))?;
    }
    ensure(of_cable < 0.01 && pieces >= 12.0, (of_cable, pieces))
}

fn swept() -> Checked {
    let place = tempfile::tempdir()?;
    let steps =
        "[[steps]]\nname = \"in\"\nincrements = 4\nmove = [{ constraint = \"plug-B\", position = [0.3, 0, 0] }]\n";
    let sweep_of_lengths = "swept = \"5 mm\"\n[sweep.vary]\n\"branches.cable.length\" = { values = [0.9, 1.0, 1.1] }\n";
    fs::write(place.path().join("s.toml"), cable(&[sweep_of_lengths, steps].concat()))?;
    let box_of = |file: &str| -> Result<[f64; 6], Failed> {
        let json = glb(&place.path().join(file))?;
        let accessors = json["accessors"].as_array().ok_or("no accessors")?;
        let position = accessors.iter().find(|one| one["min"].is_array()).ok_or("no positions")?;
        let read = |end: &str, k: usize| position[end][k].as_f64().unwrap_or(f64::NAN);
        Ok([0, 1, 2, 3, 4, 5].map(|k| if k < 3 { read("min", k) } else { read("max", k - 3) }))
    };
    ensure(sweep(place.path(), "o").arg("--quiet").status()?.success(), "the sweep fails")?;
    let all = box_of("o/swept.glb")?;
    let mut around =
        [f64::INFINITY, f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    let text = fs::read_to_string(place.path().join("s.toml"))? + "[output]\nswept = \"5 mm\"\n";
    fs::write(place.path().join("r.toml"), text)?;
    for point in ["0", "1", "2"] {
        let mut run = Command::new(program());
        let run = run.args(["run", "r.toml", "--quiet", "--out", "r", "--point", point]).current_dir(place.path());
        ensure(run.status()?.success(), point)?;
        let own = box_of("r/swept.glb")?;
        for k in 0..6 {
            around[k] = if k < 3 { around[k].min(own[k]) } else { around[k].max(own[k]) };
        }
    }
    ensure(all.iter().zip(around).all(|(a, b)| (a - b).abs() < 1e-4), (all, around))
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

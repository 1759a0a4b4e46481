//! The program with its minimiser `gpu`, where there is a device: `WIRELOOM_GPU_TESTS` says which (see
//! `wireloom::gpu::policy`).

use libtest_mimic::{Arguments, Failed, Trial};
use std::fs;
use std::process::{Command, ExitCode};
use std::sync::{Arc, OnceLock};
use wireloom::export::table::{Column, Table, read};
use wireloom::geometry::Vector;
use wireloom::gpu::policy::TestDevice;
use wireloom::gpu::{Gpu, SharedDevice, policy};
use wireloom::session::Monitor;
use wireloom::{Control, Run, Status};
use wireloom_tests::cables::{self, branch, connector};
use wireloom_tests::program;

type Check = fn(&Arc<Gpu>) -> Result<(), Failed>;

const CHECKS: &[(&str, Check)] = &[
    ("a sweep on a device has the rows of one on the CPU", sweep),
    ("a device that is lost in a run ends it, and what was finished is kept", lost),
    ("the method of gradients comes where Newton's comes, and the result names the device", gradients),
    ("what single precision leaves is said, and finished on request", single),
    ("a studio on a device ends in good order whenever it is stopped", stopped),
];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let found = policy::device(std::env::var("WIRELOOM_GPU_TESTS").ok().as_deref());
    let trials = CHECKS.iter().map(|&(name, check)| match found.clone() {
        TestDevice::Device(gpu) => Trial::test(name, move || check(&gpu)),
        TestDevice::Ignored(reason) => {
            Trial::test(format!("{name} (ignored: {reason})"), || Ok(())).with_ignored_flag(true)
        }
        TestDevice::Missing(reason) => Trial::test(name, move || Err(reason.into())),
    });
    libtest_mimic::run(&arguments, trials.collect()).exit_code()
}

/// A trunk and two arms, all ends plugged; then one plug is moved.
fn harness() -> String {
    let joint = r#"
[[joints]]
name = "J"
model = "fused"
arms = [
  { branch = "trunk", direction = [-1, 0, 0], up = [0, 0, 1] },
  { branch = "left", direction = [0.8, 0.6, 0], up = [0, 0, 1] },
  { branch = "right", direction = [0.8, -0.6, 0], up = [0, 0, 1] },
]
"#;
    [
        "schema = 1\nname = \"fork\"\n",
        &cables::section("cable"),
        &branch("trunk", ["A", "J"], "cable", 0.4, 16),
        &branch("left", ["J", "B"], "cable", 0.3, 12),
        &branch("right", ["J", "C"], "cable", 0.3, 12),
        joint,
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        &connector("plug-B", "B", [0.55, 0.15, 0.0]),
        &connector("plug-C", "C", [0.55, -0.15, 0.0]),
    ]
    .concat()
}

/// Precision that leaves nothing to the CPU, or little.
fn precision(gpu: &Gpu) -> &'static str {
    if gpu.info.double { "f64" } else { "f32" }
}

/// The harness, one plug of which is moved in four increments, with these options of the minimiser. Its rods are of
/// first order: those of fourth order are never left to a device alone.
fn moved(options: &str) -> String {
    let harness = harness().replace("segments = ", "rod = \"mass-spring\"\nsegments = ");
    format!(
        "{harness}
[output]
increments = true
[[steps]]
name = \"move\"
increments = 4
[[steps.move]]
constraint = \"plug-B\"
position = [0.5, 0.25, 0.1]
[minimiser]
{options}
"
    )
}

/// The device of all tests but those that lose theirs: opened, and its shaders compiled, once.
fn shared(gpu: &Gpu) -> SharedDevice {
    static SHARED: OnceLock<SharedDevice> = OnceLock::new();
    SHARED.get_or_init(|| SharedDevice::for_single_runs(Some(&gpu.info.name))).clone()
}

fn run(text: &str, devices: &SharedDevice, mut each: impl FnMut(usize)) -> Result<Run, Failed> {
    let registry = wireloom::registry_on(devices.clone(), &Monitor::default());
    let (_, built) = wireloom::load(text, &registry).map_err(|faults| wireloom::scenario::render(text, &faults))?;
    Ok(wireloom::run(built, &mut |progress, _| {
        each(progress.increment);
        Control::Continue
    }))
}

fn positions(run: &Run) -> Vec<Vector> {
    run.steps.last().into_iter().flat_map(|end| &end.branches).flat_map(|b| b.position.clone()).collect()
}

/// Largest distance (m) between the last equilibria of two runs.
fn apart(one: &Run, other: &Run) -> f64 {
    let (one, other) = (positions(one), positions(other));
    assert!(!one.is_empty() && one.len() == other.len(), "{} and {} positions", one.len(), other.len());
    one.iter().zip(&other).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn gradients(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let devices = shared(gpu);
    let own = precision(gpu);
    let polish = !gpu.info.double;
    let by_gradients = moved(&format!(
        "kind = \"gpu\"\nalgorithm = \"gradient\"\nprecision = \"{own}\"\npolish = {polish}\nmax_iterations = 2000"
    ));
    let found = run(&by_gradients, &devices, |_| ())?;
    let newton = run(&moved("kind = \"newton\""), &devices, |_| ())?;
    assert_eq!((found.status(), newton.status()), (Status::Converged, Status::Converged), "{:?}", found.notes);
    // Both are certified to 1e-6 of the load scale.
    assert!(apart(&found, &newton) < 1e-5, "{} m apart", apart(&found, &newton));
    for (end, on_the_processor) in found.steps.iter().zip(&newton.steps) {
        assert_eq!(end.minimiser.device, Some(format!("{}, {own}", gpu.info.name)));
        assert_eq!(on_the_processor.minimiser.device, None);
        assert_eq!(end.minimiser.polish > 0, polish, "{:?}", end.minimiser);
    }
    Ok(())
}

fn lost(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let devices = SharedDevice::for_single_runs(Some(&gpu.info.name));
    let own = devices.get()?;
    let found = run(&moved("kind = \"gpu\""), &devices, |increment| {
        if increment == 2 {
            own.destroy();
        }
    })?;
    assert_eq!(found.status(), Status::Failed);
    let fault = found.fault().ok_or("no fault")?;
    assert!(fault.message.contains("lost"), "{fault}");
    assert_eq!((fault.step.as_str(), fault.increment), ("move", 3), "{fault}");
    let kept: Vec<(usize, Status)> = found.steps.iter().map(|end| (end.increment, end.status)).collect();
    assert_eq!(kept, [(1, Status::Converged), (2, Status::Converged)]);
    Ok(())
}

/// Without polish a run in single precision either meets the tolerance or says that it does not; with it, it does.
fn single(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let devices = shared(gpu);
    let with = |polish: bool| moved(&format!("kind = \"gpu\"\nprecision = \"f32\"\npolish = {polish}"));
    let raw = run(&with(false), &devices, |_| ())?;
    for end in &raw.steps {
        let met = end.minimiser.force_residual <= 1e-6;
        assert_eq!(end.status == Status::Converged, met, "{:?}: {:?}", end.status, end.minimiser);
        // EA ε over the force scale, 10⁴ N × 6e-8 / 0.2 N, is 3e-3: the strain has more digits than that.
        assert!(end.minimiser.force_residual < 1e-3, "{:?}", end.minimiser);
    }
    let polished = run(&with(true), &devices, |_| ())?;
    assert_eq!(polished.status(), Status::Converged);
    // An iteration or two each, of all increments so far: from where the device leaves it Newton's method has hardly a
    // way to go.
    for (k, end) in polished.steps.iter().enumerate() {
        assert!((1..=2 * (k + 1)).contains(&end.minimiser.polish), "{:?}", end.minimiser);
    }
    let newton = run(&moved("kind = \"newton\""), &devices, |_| ())?;
    assert!(apart(&polished, &newton) < 1e-5, "{} m apart", apart(&polished, &newton));
    Ok(())
}

fn numbers<'a>(table: &'a Table, name: &str) -> Result<&'a [Option<f64>], Failed> {
    match table.column(name) {
        Some(Column::Numbers(numbers)) => Ok(numbers),
        other => Err(format!("{name}: {other:?}").into()),
    }
}

fn sweep(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let place = tempfile::tempdir()?;
    let harness = harness();
    let text = format!(
        "{harness}
[sweep]
method = \"latin-hypercube\"
samples = 40
seed = 3
[sweep.vary]
\"branches.left.length\" = {{ from = \"280 mm\", to = \"320 mm\" }}
\"constraints.plug-C.position.0\" = {{ from = 0.5, to = 0.55 }}
\"sections.cable.bending_stiffness\" = {{ values = [0.01, 0.02] }}
"
    );
    fs::write(place.path().join("s.toml"), text)?;
    let mut tables = Vec::new();
    for minimiser in ["newton", "gpu"] {
        let mut command = Command::new(program());
        command.args(["sweep", "s.toml", "--out", minimiser, "--minimiser", minimiser]);
        if minimiser == "gpu" {
            command.args(["--device", &gpu.info.name]);
        }
        let done = command.current_dir(place.path()).output()?;
        let said = String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{minimiser}: {said}");
        assert!(said.contains("40 points: 40 converged"), "{minimiser}: {said}");
        let table = read(fs::read(place.path().join(minimiser).join("points.parquet"))?)?;
        let polished = numbers(&table, "polish")?.iter().flatten().filter(|polish| **polish > 0.0).count();
        // What the CPU had to finish is told.
        assert_eq!(said.contains("finished on the CPU"), polished > 0, "{said}");
        tables.push(table);
    }
    let [newton, gpu] = &tables[..] else { return Err("two tables".into()) };
    for name in ["energy.total", "branches.left.length"] {
        let pairs = numbers(newton, name)?.iter().zip(numbers(gpu, name)?);
        let off = pairs.map(|(a, b)| (a.unwrap_or(f64::NAN) - b.unwrap_or(f64::NAN)).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{name}: {off}");
    }
    Ok(())
}

/// Its driver was once taken apart by the process while the solver was within it: about one stop in fifty ended with
/// SIGSEGV.
fn stopped(_: &Arc<Gpu>) -> Result<(), Failed> {
    use std::io::{BufRead, BufReader};
    use std::time::Duration;
    if !cfg!(unix) {
        return Ok(());
    }
    let place = tempfile::tempdir()?;
    let file = place.path().join("fork.toml");
    fs::write(&file, format!("{}\n[minimiser]\nkind = \"gpu\"\n", harness()))?;
    let mut random = fastrand::Rng::with_seed(49);
    for round in 0..20 {
        let mut child = Command::new(program())
            .args(["studio", "--no-open"])
            .arg(&file)
            .env("XDG_STATE_HOME", place.path())
            .stdout(std::process::Stdio::piped())
            .spawn()?;
        let mut lines = BufReader::new(child.stdout.take().ok_or("piped")?).lines();
        lines.find(|line| line.as_ref().is_ok_and(|line| line.starts_with("http://"))).ok_or("no address")??;
        std::thread::sleep(Duration::from_millis(random.u64(0..1500)));
        let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status()?;
        if !killed.success() {
            return Err("it had ended before".into());
        }
        let status = child.wait()?;
        if !status.success() {
            return Err(format!("round {round}: {status}").into());
        }
    }
    Ok(())
}

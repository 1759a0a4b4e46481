//! The command line.

pub mod values;

use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;
use wireloom_dataset::POINTS;

/// Computes how a branched cable harness hangs, bends, twists and pulls while it is being installed.
///
/// Exit codes: 0 converged; 1 the input was refused; 2 not converged or interrupted (everything computed is still
/// written), or (`identify`) a number is not identifiable; 3 a file or folder could not be read or written, or a plugin
/// failed; 4 (`verify`, `optimise`) converged, but a requirement that must be kept fails or is unresolved.
#[derive(Parser)]
#[command(name = "wireloom", version)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Carry out a scenario and write its results
    ///
    /// Writes result.json, picture.svg, and all other files that the scenario's [output] asks for: CSV tables, VTK
    /// files for ParaView, a report. Ctrl-C (or SIGTERM) stops at once and keeps the increments that are done; after
    /// that, or after a kill or a crash, --resume leads to the same result.
    Run(RunArguments),
    /// Carry out a scenario and say whether its requirements are kept
    ///
    /// Prints the sheet: for each requirement its verdict, worst value over all increments, limit, margin, place and
    /// step; the worst first. Then the verdict on the harness and the status of the run, which are two things. Writes
    /// the same files as `run`, into the same folder. Exit code 4: the run converged, but a requirement that must be
    /// kept fails or is unresolved. A run that did not converge ends with 2, whatever its sheet says: its values are
    /// not those of the whole assembly.
    Verify(VerifyArguments),
    /// Check scenarios without carrying them out, and show all their faults at once
    Check {
        /// The scenarios
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        #[command(flatten)]
        allowed: Allowed,
    },
    /// Drag a harness in the browser, or play a finished run
    ///
    /// Opens a page, and prints its address with a token, a new one each time: anyone who knows it can use the
    /// session. Connectors, clips and points of the cables can be dragged; the motions become steps of the scenario.
    /// Lengths, sections, clips, branches, obstacles and requirements can be changed, and the text itself; the page
    /// saves it in its file. Unsaved changes are kept as a draft, in the user's folder for states of
    /// programs, and offered the next time. Ctrl-C ends the session.
    Studio(StudioArguments),
    /// Show the differences between results, and why they are not the same equilibrium
    ///
    /// Takes folders that `run` has written, and scenarios, which are carried out (without writing results; after
    /// Ctrl-C those that are done are compared). Or one scenario with options such as --joint cosserat,rigid-body,
    /// --segments 20,40,80; of several such options, every combination.
    Compare(CompareArguments),
    /// Carry out a scenario over all values of its [sweep], on all cores
    ///
    /// Writes points.parquet, a row for each point, and prints how many points pass, which requirements fail, and which
    /// keys drive them. A point that is refused, reaches its time limit or crashes is a row with its status, also where
    /// a plugin crashes or does not return. After Ctrl-C, a kill or a crash the same command continues.
    Sweep(SweepArguments),
    /// Derivatives of results at the end of a step by numbers of the scenario
    ///
    /// Carries out the scenario up to that step, without writing results, and prints for each output how much it
    /// changes for one unit more of each key. Where contact changes, another place becomes the worst, or the harness is
    /// about to snap, it says so, and gives one value for each side. Friction and everything else that has a history
    /// stays as it is at the end of the step.
    Sensitivities(SensitivitiesArguments),
    /// Identify numbers of the scenario, such as a bending stiffness, from measured points of the real harness
    ///
    /// Carries out the scenario with other values until its [[markers]] come as near to the measured points as they
    /// can (robust least squares). Prints each value with its deviation, its 95 % interval and correlations, and the
    /// distances in each configuration. A value that the points do not determine is `not identifiable`, and has no
    /// value: then, and where the fit does not converge, the exit code is 2.
    Identify(IdentifyArguments),
    /// Choose numbers and words of a scenario so that an objective is smallest and all requirements are kept
    ///
    /// The scenario's [optimise] has the keys to vary, their ranges, and what to minimise. Every run is a line, and a
    /// row of designs.csv; the best design becomes optimum.toml, with the comments of its author, and is run afresh:
    /// optimum.json has the sheet of that run. After Ctrl-C the best design so far is kept. Exit code 0: it is a local
    /// optimum, and the fresh run passes; 4: runs converge, but no design was found that keeps all requirements.
    Optimise(OptimiseArguments),
    /// Show a sweep as one HTML page: verdicts, the region that fails, drivers of requirements, distributions
    ///
    /// (The page of a run is written by `run --report`.)
    Report {
        /// Folder that `sweep` has written, or its points.parquet
        #[arg(value_name = "DIR")]
        results: PathBuf,
        /// File for the page [default: report.html beside the table]
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Print the JSON Schema of scenario files, for editors that complete and check
    Schema,
    /// List every rod, joint, constraint and minimiser with its parameters, their units and defaults
    Models {
        #[command(flatten)]
        allowed: Allowed,
    },
    /// List the GPUs of this machine (and those in software) that the minimiser `gpu` may run on
    Devices,
    /// Explain a key of scenarios: its meaning, its values and an example
    Explain {
        /// The key, such as `length`, `branches.length` or `minimiser.memory`; or the name of a kind, such as `ncg`
        key: String,
        #[command(flatten)]
        allowed: Allowed,
    },
    /// Make a scenario from a harness file of another format, or obstacles from the surroundings in a STEP file
    Import {
        #[command(subcommand)]
        format: Format,
    },
    /// Write a result back into the harness file that its scenario was imported from
    Export {
        #[command(subcommand)]
        format: HarnessFile,
    },
    /// Lay the harness of a scenario, a KBL or a VEC file flat on a formboard, and draw it at 1:1
    ///
    /// Writes board.svg, board.dxf, board.pdf (pages at 1:1 with marks, tables of parts, branches and wires) and
    /// board.toml, a scenario of the harness built flat: it is at rest there, held by pegs. Branches have their true
    /// lengths; none cross or come nearer to each other than their radii and the gap, except beside forks. The trunk,
    /// which is the longest way through the harness, is straight unless the board is shorter; loops are cut open.
    Formboard(FormboardArguments),
    /// Make, check and list plugins: libraries with further kinds
    Plugin {
        #[command(subcommand)]
        task: PluginTask,
    },
    /// Report the crash of a plugin (the program starts itself with this)
    #[command(hide = true)]
    PluginFault(PluginFault),
    /// Compute chains of points of a sweep with plugins (the program starts itself with this)
    #[command(hide = true)]
    SweepProcess(ProcessArguments),
    /// Measure the time of a small move of a held end, with each minimiser, and of a sweep of many points
    Bench(BenchArguments),
}

#[derive(Args)]
pub struct BenchArguments {
    /// As JSON, for programs
    #[arg(long)]
    pub json: bool,
    /// Points of the sweep
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub points: u32,
    /// Largest number of iterations of a step
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub iterations: u32,
    /// Only the minimiser `gpu` on this device (a number of `wireloom devices`, or part of a name), and `newton` on
    /// one core, as JSON
    #[arg(long, value_name = "DEVICE", conflicts_with_all = ["harness", "iterations"])]
    pub device: Option<String>,
    /// Also the installation of a real harness from the board into the vehicle (about a minute), a move of one of its
    /// plugs, and its rest with contact among all its cables
    #[arg(long, value_name = "FILE.kbl")]
    pub harness: Option<PathBuf>,
    /// Append all figures to this file as one line of JSON, with time, program, commit and machine; a file that is no
    /// such history is refused and kept
    #[arg(long, value_name = "FILE")]
    pub history: Option<PathBuf>,
}

#[derive(Args)]
pub struct RunArguments {
    /// The scenario
    #[arg(required_unless_present = "resume")]
    pub file: Option<PathBuf>,
    /// Resume the run that was interrupted in this folder
    ///
    /// The scenario and the files it names must be unchanged. The result is the same, to the last bit, as that of a
    /// run without interruption; only times differ.
    #[arg(long, value_name = "DIR")]
    #[arg(conflicts_with_all = ["file", "out", "minimiser", "set", "point", "report", "page"])]
    pub resume: Option<PathBuf>,
    /// Folder for the results, made where it is missing [default: out/ and the name of FILE without .toml]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Find equilibria with this minimiser instead of the scenario's
    #[arg(long, value_name = "KIND")]
    pub minimiser: Option<String>,
    /// Replace the value of a key, such as branches.left.length="500 mm" (`*` stands for every entry of a list)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Carry out this point of the scenario's [sweep], counted from 0, to see its shape
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub point: Option<usize>,
    /// Write report.html, the whole run as one page, as with `report = true` in the scenario's [output]
    #[arg(long)]
    pub report: bool,
    /// Also write the run, increment by increment, as one page that any browser plays without this program
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// Print nothing but faults
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub trace: TraceArguments,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Args)]
pub struct VerifyArguments {
    /// The scenario
    pub file: PathBuf,
    /// Print the sheet as JSON, with the keys of result.json
    #[arg(long)]
    pub json: bool,
    /// Folder for the results, made where it is missing [default: out/ and the name of FILE without .toml]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Find equilibria with this minimiser instead of the scenario's
    #[arg(long, value_name = "KIND")]
    pub minimiser: Option<String>,
    /// Replace the value of a key, such as branches.left.length="500 mm" (`*` stands for every entry of a list)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Verify this point of the scenario's [sweep], counted from 0
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub point: Option<usize>,
    /// Write report.html, the whole run as one page that begins with the sheet
    #[arg(long)]
    pub report: bool,
    /// Print nothing but faults
    #[arg(long, short, conflicts_with = "json")]
    pub quiet: bool,
    #[command(flatten)]
    pub trace: TraceArguments,
    #[command(flatten)]
    pub allowed: Allowed,
}

impl VerifyArguments {
    /// The run that is verified.
    pub fn run(&self) -> RunArguments {
        let Self { file, json, out, minimiser, set, point, report, quiet, trace, allowed } = self;
        RunArguments {
            file: Some(file.clone()),
            resume: None,
            out: out.clone(),
            minimiser: minimiser.clone(),
            set: set.clone(),
            point: *point,
            report: *report,
            page: None,
            // Only the sheet may stand on standard output.
            quiet: *quiet || *json,
            trace: trace.clone(),
            allowed: allowed.clone(),
        }
    }
}

/// The trace of the solver.
#[derive(Args, Clone)]
pub struct TraceArguments {
    /// Show the work of the solver on standard error: -v a line for each increment, -vv a line for each iteration
    ///
    /// Columns of -vv: iteration of this solve; energy (J); residual, relative to the loads of each branch; step
    /// length of the line search (1: the full Newton step); shift of the Hessian (0: it was positive definite);
    /// contact points; factorisations so far.
    #[arg(long, short, action = clap::ArgAction::Count, conflicts_with = "quiet")]
    pub verbose: u8,
    /// Write the spans and events of the solver to a file, one JSON object a line
    #[arg(id = "trace", long = "trace", value_name = "FILE")]
    pub file: Option<PathBuf>,
}

#[derive(Args)]
pub struct StudioArguments {
    /// A scenario, to be changed interactively; or a folder that `run` has written, to be played [default: a page with
    /// recent files, examples, a new harness, and a place for scenarios and KBL files]
    #[arg(value_name = "FILE|DIR")]
    pub what: Option<PathBuf>,
    /// Show the tolerance envelope of the sweep in this folder, too: the space that it swept, and tubes that hold each
    /// branch in a share of its points
    #[arg(long, value_name = "DIR", requires = "what")]
    pub envelope: Option<PathBuf>,
    /// Port to listen at [default: that of the last session, or any]
    #[arg(long, value_name = "N")]
    pub port: Option<u16>,
    /// Address to listen at; with any but this machine's own, others who know the token can connect
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    pub host: String,
    /// Only print the address
    #[arg(long)]
    pub no_open: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

/// Plugins that the user trusts, and a device.
#[derive(Args, Clone, Default)]
pub struct Allowed {
    /// Allow a plugin that the scenario names: native code, with all your rights
    ///
    /// FILE is the library. `run`, `sweep` and `compare` also load plugins from folders of the search path: those of
    /// the variable WIRELOOM_PLUGINS, and .wireloom/plugins in the home folder. `check` loads only plugins that are
    /// allowed here.
    #[arg(long = "allow-plugin", value_name = "FILE")]
    pub allow_plugin: Vec<PathBuf>,
    /// Run the minimiser `gpu` on this device: its number in `wireloom devices`, or part of its name
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
}

#[derive(Subcommand)]
pub enum PluginTask {
    /// Make a folder with a plugin, ready to be built: source, README, scenario, test
    New {
        /// Its name: letters, digits and hyphens
        name: String,
        /// What it adds
        #[arg(long, value_enum, default_value_t = PluginKind::Constraint)]
        kind: PluginKind,
        /// In C instead of Rust
        #[arg(long)]
        c: bool,
        /// In C++ instead of Rust
        #[arg(long, conflicts_with = "c")]
        cpp: bool,
        /// Folder of the sources of this program, which a plugin in Rust is built with
        #[arg(long, value_name = "DIR", conflicts_with_all = ["c", "cpp"])]
        sources: Option<PathBuf>,
    },
    /// Load a plugin and test its contract
    ///
    /// Derivatives, objectivity where claimed, the same bits for the same input, input that is not finite or extreme,
    /// several threads, panics, memory over 10 000 cycles of creation and destruction, time of an evaluation.
    Check {
        /// The library
        file: PathBuf,
        /// Time limit of one call, s
        #[arg(long, value_name = "SECONDS", default_value_t = 10.0, allow_negative_numbers = true)]
        time_limit: f64,
    },
    /// Show the plugins of the search path, with their kinds and parameters
    List,
}

/// What a new plugin adds.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum PluginKind {
    /// A constraint with a potential: a spring
    Constraint,
    /// A constraint that sets an equation: a rigid link
    Equation,
    /// A constraint that remembers: a spring that yields
    Memory,
    /// A joint model: springs between the arms
    Joint,
    /// A rod: a bundle that bends more easily the more it is bent
    Rod,
}

/// The crash of a plugin.
#[derive(Args)]
pub struct PluginFault {
    /// Folder of the run, where one had begun
    #[arg(long, requires = "step", requires = "increment")]
    pub folder: Option<PathBuf>,
    /// Step
    #[arg(long)]
    pub step: Option<String>,
    /// Its increment
    #[arg(long)]
    pub increment: Option<usize>,
    /// In a process that computes points of a sweep: the report is a message to it
    #[arg(long, conflicts_with = "folder")]
    pub sweep: bool,
    /// Plugin and constraint
    pub site: String,
    /// Function
    pub function: String,
    /// The crash, in words
    pub happened: String,
}

#[derive(Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct SweepArguments {
    #[command(subcommand)]
    pub task: Option<SweepTask>,
    /// The scenario
    #[arg(required = true)]
    pub file: Option<PathBuf>,
    /// Folder for the results, made where it is missing [default: out/ and the name of FILE without .toml]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Find equilibria with this minimiser instead of the scenario's
    #[arg(long, value_name = "KIND")]
    pub minimiser: Option<String>,
    /// Write the table as points.csv, too
    #[arg(long)]
    pub csv: bool,
    /// Write the points in parts, as Parquet files, into this folder or object store, which any number of machines may
    /// do at a time
    ///
    /// Computes the points that no part has yet, or those of --points. A part is created only where there is none of
    /// its name, so duplicates and retries do no harm. `sweep status` and `sweep compact` take the same URL.
    #[arg(long, value_name = "DIR|URL", conflicts_with_all = ["out", "csv"])]
    pub into: Option<String>,
    /// Compute these points alone, counted from 0; the last number does not count
    #[arg(long, value_name = "A..B", requires = "into", value_parser = values::range)]
    pub points: Option<Range<usize>>,
    /// Number of points of a part, without --points
    #[arg(long, value_name = "N", requires = "into", conflicts_with = "points", default_value_t = POINTS)]
    #[arg(allow_negative_numbers = true, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    pub each: usize,
    /// Write these columns of the table only, besides point, status and message
    #[arg(long, value_name = "COLUMN", requires = "into", num_args = 1.., value_delimiter = ',')]
    pub columns: Option<Vec<String>>,
    /// Print nothing but faults
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Subcommand)]
pub enum SweepTask {
    /// Say which points of a sweep in parts are missing, which failed and why, and how fast it grows
    ///
    /// Exit code 2: points are missing.
    Status {
        /// What --into was given
        #[arg(value_name = "DIR|URL")]
        place: String,
    },
    /// Write one sorted table of all parts, points.parquet, beside them
    ///
    /// Refused while points are missing or a part is damaged. The table has the bytes of the one that `sweep` writes.
    Compact {
        /// What --into was given
        #[arg(value_name = "DIR|URL")]
        place: String,
        /// Print nothing but faults
        #[arg(long, short)]
        quiet: bool,
    },
}

#[derive(Args)]
pub struct SensitivitiesArguments {
    /// The scenario
    pub file: PathBuf,
    /// Requirements, by name, or columns of a sweep's table such as force.plug-B, bend_radius.trunk, energy.total,
    /// position_x.MARKER [default: the requirements that the scenario and its sections give, as far as they have a
    /// value at the end of the step]
    #[arg(long, value_name = "OUTPUT", num_args = 1..)]
    pub of: Vec<String>,
    /// Keys of the scenario that hold a number, such as branches.left.length or constraints.clip-1.position.2 [default:
    /// those that its [sweep] varies]
    #[arg(long, value_name = "KEY", num_args = 1..)]
    pub by: Vec<String>,
    /// The step at whose end they are taken [default: the last one]
    #[arg(long, value_name = "NAME")]
    pub step: Option<String>,
    /// Print them as JSON, for programs
    #[arg(long)]
    pub json: bool,
    /// Write what is printed to this file instead
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Args)]
pub struct IdentifyArguments {
    /// The scenario
    pub file: PathBuf,
    /// Measured points: tables with the columns configuration, marker, x, y, z (m)
    ///
    /// A configuration is the end of the step of that name, or the only step. A marker is one of [[markers]], a joint
    /// or an end; instead of it, the columns branch, s (m) name a place by its arc length. An empty cell is a
    /// coordinate that was not measured. All tables together are one fit.
    #[arg(long, value_name = "FILE.csv", num_args = 1.., required_unless_present = "bending")]
    pub shapes: Vec<PathBuf>,
    /// Measured bending curves: tables with the columns load_N, deflection_mm
    ///
    /// The scenario describes the test: its steps move one constraint, which is the indenter; its way is the
    /// deflection, and its force along the way the load. Samples beyond the way of the scenario are left out. All
    /// tables together are one fit.
    #[arg(long, value_name = "FILE.csv", num_args = 1.., conflicts_with = "shapes")]
    pub bending: Vec<PathBuf>,
    /// Keys of the scenario that hold the numbers to identify, such as sections.cable.bending_stiffness
    #[arg(long, value_name = "KEY", num_args = 1.., value_delimiter = ',', required = true)]
    pub fit: Vec<String>,
    /// What is known of a number before, SI or with a unit ("5 mm") [default: of values that follow from wires the rule
    /// with its uncertainty; of others hardly anything, a factor of ten]
    #[arg(long, value_name = "KEY=VALUE,DEVIATION")]
    pub prior: Vec<String>,
    /// Bounds of a number, SI or with a unit [default: a factor of 10000 to both sides of the scenario's value]
    #[arg(long, value_name = "KEY=MIN,MAX")]
    pub bounds: Vec<String>,
    /// Numbers of neighbours, such as the curvatures along a cable, that differ by this deviation, SI or with a unit
    #[arg(long, value_name = "KEY,KEY,...=DEVIATION")]
    pub smooth: Vec<String>,
    /// Standard deviation of a measured coordinate, m, or load, N [default: that of the differences which remain]
    #[arg(long, value_name = "DEVIATION", allow_negative_numbers = true)]
    pub noise: Option<f64>,
    /// Print the answer as JSON, for programs
    #[arg(long)]
    pub json: bool,
    /// Write identified.json, the scenario with the fitted values (fitted.toml) and a picture of measured and computed
    /// shapes (shapes.svg) or curves (curves.svg) into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Args)]
pub struct OptimiseArguments {
    /// The scenario
    pub file: PathBuf,
    /// Folder for the results, made where it is missing [default: out/ and the name of FILE without .toml]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print optimum.json instead of the lines, for programs
    #[arg(long)]
    pub json: bool,
    /// Print nothing but faults
    #[arg(long, short, conflicts_with = "json")]
    pub quiet: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

/// The scenario of a process that computes points.
#[derive(Args)]
pub struct ProcessArguments {
    /// The scenario
    pub file: PathBuf,
    /// Minimiser instead of the scenario's
    #[arg(long)]
    pub minimiser: Option<String>,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Args)]
pub struct CompareArguments {
    /// Folders with results, result.json files, scenarios (.toml), or one KBL or VEC file (.kbl, .xml, .vec): the
    /// variants of its harness, as installed
    #[arg(required = true, value_name = "DIR|FILE")]
    pub inputs: Vec<PathBuf>,
    /// Of a KBL or VEC file: take these variants instead of all that have modules
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub variants: Vec<String>,
    /// Run the one scenario given (or each variant) with each of these models for all its joints
    #[arg(long, value_name = "MODELS", value_delimiter = ',')]
    pub joint: Vec<String>,
    /// ... with each of these rods for all its branches
    #[arg(long, value_name = "RODS", value_delimiter = ',')]
    pub rod: Vec<String>,
    /// ... with each of these minimisers
    #[arg(long, value_name = "KINDS", value_delimiter = ',')]
    pub minimiser: Vec<String>,
    /// ... with each of these numbers of segments for every branch; with three or more, their convergence
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', allow_negative_numbers = true)]
    pub segments: Vec<usize>,
    /// ... with each of these values for a key, such as branches.left.length=0.4,"500 mm" (`*` stands for every entry)
    #[arg(long, value_name = "KEY=VALUES")]
    pub set: Vec<String>,
    /// Print the comparison as JSON, for programs
    #[arg(long)]
    pub json: bool,
    /// Write what is printed to this file instead
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write the comparison as one HTML page, with all shapes in one picture
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Largest distance of shapes that are the same, in metres or with a unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "1 mm",
        allow_hyphen_values = true,
        value_parser = values::length
    )]
    pub tolerance: f64,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub trace: TraceArguments,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Subcommand)]
pub enum Format {
    /// KBL (VDA 4964): topology, centre curves, wires, connectors and fixings of a harness
    Kbl(HarnessArguments),
    /// VEC (VDA 4968), versions 1.2 to 2.2: topology, 3D geometry, wires, connectors and fixings of a harness
    ///
    /// A file without 3D geometry says how long its segments are, not where they lie: --as board lays it on a board.
    Vec(HarnessArguments),
    /// STEP (ISO 10303-21): the parts of an assembly as meshes, and obstacles that place them. Python reads it with
    /// Open CASCADE: python3 -m pip install "cadquery-ocp-novtk>=8"
    Step(StepArguments),
}

#[derive(Subcommand)]
pub enum HarnessFile {
    /// KBL (VDA 4964): centre curves, lengths, nodes, places of fixings and connectors as they were computed
    ///
    /// Segments get the computed centre lines (cubic B-splines) and the lengths of their branches; nodes, placements
    /// and places of fixings move with the harness. All else in the file keeps its bytes, and so does what has not
    /// moved: a curve that is within the tolerance of the computed line, a length that is the same. Lengths of wires,
    /// dimensions and coverings stay those of the file; KBL has no element for the bend radius of a segment. Prints the
    /// lengths that were changed since the import, by hand or by `optimise`.
    ///
    /// Refused: a run that did not converge, another file than the one that the scenario was imported from, branches
    /// that end apart where the file has one node. Branches without a segment are listed, and not written; the halves
    /// of a branch that was split become one segment again. Imported again, the file gives the same lengths, and lines
    /// within the tolerance; clips are drawn beside the cable, and come back to some 0.1 mm along it.
    Kbl(KblExportArguments),
}

#[derive(Args)]
pub struct KblExportArguments {
    /// A folder that `run` has written, its result.json, or the scenario, which is carried out (nothing else is
    /// written)
    #[arg(value_name = "DIR|FILE")]
    pub result: PathBuf,
    /// The KBL file that the scenario was imported from [default: that of the name in the scenario's [kbl], in the
    /// current folder or beside the result]
    #[arg(long, value_name = "FILE.kbl")]
    pub kbl: Option<PathBuf>,
    /// The KBL file to write
    #[arg(short, long, value_name = "FILE.kbl")]
    pub output: PathBuf,
    /// Largest distance of the centre curves from the computed lines, in mm or with a unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "0.1 mm",
        allow_hyphen_values = true,
        value_parser = values::millimetres
    )]
    pub tolerance: f64,
    /// Print what was written as JSON, for programs: every segment, node, placement and fixing
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Args)]
pub struct FormboardArguments {
    /// A scenario (.toml), a KBL file (.kbl, .xml) or a VEC file (.vec)
    pub file: PathBuf,
    /// Folder for the board, made where it is missing
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Width and height of the board in mm or with units, such as 4000x1600 or "4 m x 1.6 m" [default: as many sheets
    /// A0, lying side by side, as the harness needs with a straight trunk]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = values::board)]
    pub board: Option<[f64; 2]>,
    /// Distance between the surfaces of branches beside each other, in mm or with a unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "5 mm",
        allow_hyphen_values = true,
        value_parser = values::millimetres
    )]
    pub gap: f64,
    /// Distance of the harness from the edges of the board, in mm or with a unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "50 mm",
        allow_hyphen_values = true,
        value_parser = values::millimetres
    )]
    pub margin: f64,
    /// Paper of the PDF
    #[arg(long, value_enum, default_value_t = Paper::A0)]
    pub paper: Paper,
    /// Which part of the angles of the board the harness of board.toml keeps: 1 if it is built flat and at rest, 0 if
    /// it keeps those of the file
    #[arg(long, value_name = "RATIO", default_value_t = 1.0, allow_negative_numbers = true)]
    pub memory: f64,
    /// Of a KBL or VEC file: take the modules of this variant instead of all
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,
    #[command(flatten)]
    pub allowed: Allowed,
}

/// Sizes of paper.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Paper {
    A0,
    A1,
    A2,
    A3,
    A4,
}

#[derive(Args)]
pub struct StepArguments {
    /// The STEP file
    pub file: PathBuf,
    /// Folder for the meshes, and for obstacles.toml, which a scenario in the current folder takes
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Largest distance of the triangles from the surfaces, in mm or with a unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value = "0.1 mm",
        allow_hyphen_values = true,
        value_parser = values::millimetres
    )]
    pub deflection: f64,
    /// Leave out the parts whose name, or path in the assembly, fits; * stands for any characters, ? for one
    #[arg(long, value_name = "PATTERN")]
    pub without: Vec<String>,
    /// Time after which the reading is ended, such as `30 min`
    #[arg(long, value_name = "TIME", default_value = "10 min", value_parser = humantime::parse_duration)]
    pub time_limit: Duration,
}

#[derive(Args)]
pub struct HarnessArguments {
    /// The file
    pub file: PathBuf,
    /// File for the scenario [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// List the modules and variants of the harness, and make no scenario
    #[arg(long, conflicts_with_all = ["output", "variant", "modules"])]
    pub list: bool,
    /// Import the modules of a variant of --list instead of all: wires, connectors, fixings and coverings of other ones
    /// are left out
    #[arg(long, value_name = "NAME", conflicts_with = "modules")]
    pub variant: Option<String>,
    /// Import these modules of --list instead of all
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub modules: Vec<String>,
    /// Start and end of the scenario
    #[arg(long = "as", value_name = "ARRANGEMENT", value_enum, default_value_t = HarnessArrangement::Installed)]
    pub arrangement: HarnessArrangement,
    /// Which part of the angles of the board the joints have at rest, with --as board or assembly: 1 if the harness is
    /// built flat and at rest there, 0 if its joints keep their drawn angles [default: 1 with board, 0.3 with assembly]
    #[arg(long, value_name = "RATIO", allow_negative_numbers = true)]
    pub memory: Option<f64>,
    /// Order in which an assembly installs connectors and clips [default: outward]
    #[arg(long, value_enum)]
    pub order: Option<InstallOrder>,
    /// Number of the random order [default: 0]
    #[arg(long, value_name = "N", requires = "order")]
    pub seed: Option<u64>,
    /// Largest discretisation error of bend radii, by which the mesh is made when the scenario runs [default: 2 %]
    #[arg(
        long,
        value_name = "RATIO",
        allow_hyphen_values = true,
        value_parser = values::ratio,
        conflicts_with = "spacing"
    )]
    pub accuracy: Option<f64>,
    /// Longest segment of a branch, in metres or with a unit, instead of an accuracy
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = values::length)]
    pub spacing: Option<f64>,
    /// Name of the scenario [default: the harness's name in the file]
    #[arg(long)]
    pub name: Option<String>,
}

/// Start and end of the scenario of a harness file.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum HarnessArrangement {
    /// In the vehicle, as drawn
    Installed,
    /// Flat on a formboard, held by pegs
    Board,
    /// From the board into the vehicle, one step per connector and clip
    Assembly,
}

/// Order in which an assembly installs.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum InstallOrder {
    /// Along the cable from the connector of the heaviest branch outward
    Outward,
    /// Any, by --seed
    Random,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        super::Arguments::command().debug_assert();
    }
}

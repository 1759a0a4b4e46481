//! What may stand on the command line.

pub mod values;

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Computes how a branched cable harness hangs, bends, twists and pulls while it is being installed.
///
/// Exit codes: 0 converged; 1 the input was refused; 2 not converged or interrupted (everything computed is still
/// written); 3 a file or folder could not be read or written, or a plugin failed.
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
    /// Writes result.json, picture.svg, and what else the scenario's [output] asks for: CSV tables, VTK files for
    /// ParaView, a report. Ctrl-C (or SIGTERM) stops at once and keeps the increments that are done; after that, or a kill or a crash,
    /// --resume goes on to the same result.
    Run(RunArguments),
    /// Check scenarios without carrying them out, and show all their faults at once
    Check {
        /// The scenarios
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        #[command(flatten)]
        allowed: Allowed,
    },
    /// Take hold of a harness in the browser, or watch a finished run
    ///
    /// Opens a page (and prints its address, which holds a token, a new one each time: whoever knows it may use the session). Hands move connectors, clips and points
    /// of the cables; what they do becomes steps of the scenario, which the page saves as a file. What is not saved is kept as a draft,
    /// in the user's folder for states of programs, and offered the next time. Ctrl-C ends it.
    Studio(StudioArguments),
    /// Show what differs between results, and why they are not the same equilibrium
    ///
    /// Takes folders that `run` has written, and scenarios, which are carried out for the purpose (nothing is written of them; Ctrl-C
    /// leaves those that are done).
    /// Or one scenario, and what to try in it: --joint cosserat,rigid-body, --segments 20,40,80; of several such options, every
    /// combination.
    Compare(CompareArguments),
    /// Carry out a scenario over all values of its [sweep], on all cores
    ///
    /// Writes points.parquet, a row for each point. A point that fails is a row with its status. After Ctrl-C, a kill or a crash the
    /// same command goes on.
    Sweep(SweepArguments),
    /// Show a sweep as one HTML page: distributions, responses, and which key matters most
    ///
    /// (The page of a run is written by `run --report`.)
    Report {
        /// Folder that `sweep` has written, or its points.parquet
        #[arg(value_name = "DIR")]
        results: PathBuf,
        /// Where to write the page [default: report.html beside the table]
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
    /// Say what a key of a scenario means, what it holds and how it is written
    Explain {
        /// The key, such as `length`, `branches.length` or `minimiser.memory`; or the name of a kind, such as `ncg`
        key: String,
        #[command(flatten)]
        allowed: Allowed,
    },
    /// Make a scenario from a harness file of another format
    Import {
        #[command(subcommand)]
        format: Format,
    },
    /// Make, check and list plugins: libraries with further kinds
    Plugin {
        #[command(subcommand)]
        task: PluginTask,
    },
    /// What this program becomes when a plugin has ended it
    #[command(hide = true)]
    PluginFault(PluginFault),
    /// Measure on this machine how long one small move of a held end takes, with each minimiser, and a sweep of many points
    Bench(BenchArguments),
}

#[derive(Args)]
pub struct BenchArguments {
    /// As JSON, for programs
    #[arg(long)]
    pub json: bool,
    /// Points of the sweep
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub points: u32,
    /// Iterations after which a minimiser gives up a step
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub iterations: u32,
    /// Instead of all that, the minimiser `gpu` on this device (a number of `wireloom devices`, or part of a name) beside `newton` on one core, as JSON
    #[arg(long, value_name = "DEVICE", conflicts_with_all = ["harness", "iterations"])]
    pub device: Option<String>,
    /// Also how long a real harness takes from the board into the vehicle (about a minute), and a move of one of its plugs
    #[arg(long, value_name = "FILE.kbl")]
    pub harness: Option<PathBuf>,
}

#[derive(Args)]
pub struct RunArguments {
    /// The scenario
    #[arg(required_unless_present = "resume")]
    pub file: Option<PathBuf>,
    /// Go on with the run that was interrupted in this folder
    ///
    /// The scenario and the files it names must be what they were. The result is the same, to the last bit, as that of a
    /// run that was not interrupted; only times differ.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["file", "out", "minimiser", "set", "point", "report", "page"])]
    pub resume: Option<PathBuf>,
    /// Folder for the results, made where it is missing [default: out/ and the name of FILE without .toml]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Find equilibria with this minimiser instead of the scenario's
    #[arg(long, value_name = "KIND")]
    pub minimiser: Option<String>,
    /// Give a key another value, such as branches.left.length="500 mm" (`*` stands for every entry of a list)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Carry out this point of the scenario's [sweep], counted from 0, to see its shape
    #[arg(long, value_name = "N")]
    pub point: Option<usize>,
    /// Write report.html, too: the whole run as one page, as `report = true` in the scenario's [output] does
    #[arg(long)]
    pub report: bool,
    /// Also write the run, increment by increment, as one page that any browser plays without this program
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// Print nothing but faults
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Args)]
pub struct StudioArguments {
    /// A scenario, to take hold of it; or a folder that `run` has written, to watch what is in it
    #[arg(value_name = "FILE|DIR")]
    pub what: PathBuf,
    /// Port to listen at [default: that of the last time, or any]
    #[arg(long, value_name = "N")]
    pub port: Option<u16>,
    /// Address to listen at; any but this machine's own lets others in who know the token
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    pub host: String,
    /// Only print the address
    #[arg(long)]
    pub no_open: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

/// What of this machine a command may use: plugins that the user trusts, a device.
#[derive(Args, Clone, Default)]
pub struct Allowed {
    /// Allow a plugin that the scenario names: native code, which may do whatever you may
    ///
    /// FILE is the library. `run`, `sweep` and `compare` also load what lies in a folder of the search path: those of the variable
    /// WIRELOOM_PLUGINS, and .wireloom/plugins in the home folder. `check` loads nothing but what is allowed here.
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
        /// In C instead of Rust
        #[arg(long)]
        c: bool,
        /// Where the sources of this program lie, which a plugin in Rust is built with
        #[arg(long, value_name = "DIR", conflicts_with = "c")]
        sources: Option<PathBuf>,
    },
    /// Load a plugin and try whether it keeps what it promises
    ///
    /// Derivatives, objectivity where claimed, the same bits for the same input, input that is not finite or extreme, several threads, panics, memory
    /// over 10 000 cycles of making and unmaking, time of an evaluation.
    Check {
        /// The library
        file: PathBuf,
        /// How long one call may take, s
        #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
        time_limit: f64,
    },
    /// Show the plugins of the search path, with their kinds and parameters
    List,
}

/// Whose doing it was.
#[derive(Args)]
pub struct PluginFault {
    /// Folder of the run, where one had begun
    #[arg(long, requires = "step", requires = "increment")]
    pub folder: Option<PathBuf>,
    /// Step at hand
    #[arg(long)]
    pub step: Option<String>,
    /// Increment of it
    #[arg(long)]
    pub increment: Option<usize>,
    /// Plugin and constraint
    pub site: String,
    /// Function
    pub function: String,
    /// What happened
    pub happened: String,
}

#[derive(Args)]
pub struct SweepArguments {
    /// The scenario
    pub file: PathBuf,
    /// Folder for the results, made where it is missing [default: out/ and the name of FILE without .toml]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Find equilibria with this minimiser instead of the scenario's
    #[arg(long, value_name = "KIND")]
    pub minimiser: Option<String>,
    /// Print nothing but faults
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Args)]
pub struct CompareArguments {
    /// SearchPath with results, result.json files, or scenarios (.toml)
    #[arg(required = true, value_name = "DIR|FILE")]
    pub inputs: Vec<PathBuf>,
    /// Run the one scenario given with each of these models for all its joints
    #[arg(long, value_name = "MODELS", value_delimiter = ',')]
    pub joint: Vec<String>,
    /// ... with each of these rods for all its branches
    #[arg(long, value_name = "RODS", value_delimiter = ',')]
    pub rod: Vec<String>,
    /// ... with each of these minimisers
    #[arg(long, value_name = "KINDS", value_delimiter = ',')]
    pub minimiser: Vec<String>,
    /// ... with each of these numbers of segments for every branch; of three or more, how fast results settle
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',')]
    pub segments: Vec<usize>,
    /// ... with each of these values for a key, such as branches.left.length=0.4,"500 mm" (`*` stands for every entry)
    #[arg(long, value_name = "KEY=VALUES")]
    pub set: Vec<String>,
    /// Write the comparison as one HTML page, with the shapes over each other
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Shapes nearer to each other than this are the same, in metres or with a unit
    #[arg(long, value_name = "LENGTH", default_value = "1 mm", value_parser = values::length)]
    pub tolerance: f64,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub allowed: Allowed,
}

#[derive(Subcommand)]
pub enum Format {
    /// KBL (VDA 4964): topology, centre curves, wires, connectors and constraints of a harness
    Kbl(KblArguments),
}

#[derive(Args)]
pub struct KblArguments {
    /// The KBL file
    pub file: PathBuf,
    /// Where to write the scenario [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Where the scenario begins, and where it goes
    #[arg(long = "as", value_name = "ARRANGEMENT", value_enum, default_value_t = KblArrangement::Installed)]
    pub arrangement: KblArrangement,
    /// In which order an assembly installs connectors and clips [default: outward]
    #[arg(long, value_enum)]
    pub order: Option<KblOrder>,
    /// Which of the random orders [default: 0]
    #[arg(long, value_name = "N", requires = "order")]
    pub seed: Option<u64>,
    /// Longest segment of a branch, in metres or with a unit
    #[arg(long, value_name = "LENGTH", default_value = "10 mm", value_parser = values::length)]
    pub spacing: f64,
    /// Name of the scenario [default: what the file calls the harness]
    #[arg(long)]
    pub name: Option<String>,
}

/// Where the scenario of a KBL file begins, and where it goes.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum KblArrangement {
    /// In the vehicle, as drawn
    Installed,
    /// Flat on a formboard, held by pegs
    Board,
    /// From the board into the vehicle, one step per connector and clip
    Assembly,
}

/// In which order an assembly installs.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum KblOrder {
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

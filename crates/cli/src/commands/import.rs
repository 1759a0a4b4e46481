//! `wireloom import`: harness files of other formats to scenarios, and surroundings to obstacles. Findings go to
//! standard error.

pub mod step;

use crate::arguments::{HarnessArguments, HarnessArrangement, InstallOrder};
use crate::failure::{Failure, Outcome};
use crate::files::{folder, load};
use crate::print::progress::Bar;
use crate::print::table::Columns;
use crate::print::text::found;
use crate::size;
use std::io::{self, Write};
use std::path::Path;
use wireloom::export::sha256;
use wireloom::import::kbl::{
    Arrangement, Contents, ImportError, Imported, Options, Order, Selection, Source, Usage, contents, import,
};
use wireloom::import::vec;

/// The order of an assembly; nothing else has one.
fn order(arguments: &HarnessArguments, arrangement: Arrangement) -> Result<Order, Failure> {
    let refused = |message: &str| Err(Failure::Input(message.to_owned()));
    match (arguments.order, arguments.seed) {
        (Some(_), _) if arrangement != Arrangement::Assembly => {
            refused("--order says how an assembly goes; add --as assembly")
        }
        (Some(InstallOrder::Random), seed) => Ok(Order::Random(seed.unwrap_or(0))),
        (Some(InstallOrder::Outward), Some(_)) => refused("--seed says which random order; add --order random"),
        (Some(InstallOrder::Outward) | None, _) => Ok(Order::Outward),
    }
}

/// The memory of the board, if given; a harness as installed has none.
fn memory(arguments: &HarnessArguments, arrangement: Arrangement) -> Result<Option<f64>, Failure> {
    if arguments.memory.is_some() && arrangement == Arrangement::Installed {
        let message = "--memory says how much a harness keeps of its board; add --as board or --as assembly";
        return Err(Failure::Input(message.to_owned()));
    }
    Ok(arguments.memory)
}

/// A format of harness files.
pub struct HarnessFormat {
    pub import: fn(&str, &Options) -> Result<Imported, ImportError>,
    pub contents: fn(&str) -> Result<Contents, ImportError>,
    /// Its command.
    pub command: &'static str,
}

pub const KBL: HarnessFormat = HarnessFormat { import, contents, command: "import kbl" };
pub const VEC: HarnessFormat = HarnessFormat { import: vec::import, contents: vec::contents, command: "import vec" };

impl HarnessFormat {
    /// That of a file, by the end of its name; `None`: it is no harness file.
    pub fn of(path: &Path) -> Option<&'static Self> {
        match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "kbl" | "xml" => Some(&KBL),
            "vec" => Some(&VEC),
            _ => None,
        }
    }
}

/// A harness file, for the scenario that is made from it.
pub fn source(path: &Path, text: &str) -> Source {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Source { name, sha256: sha256(text.as_bytes()) }
}

/// Accuracy of a mesh whose user asks for none.
pub const ACCURACY: f64 = 0.02;

/// Imports a harness file to a scenario, which is then checked as by `wireloom check`.
pub fn harness(arguments: &HarnessArguments, format: &HarnessFormat, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let bar = Bar::new(format!("importing {}", arguments.file.display()), true);
    let text = load::text(&arguments.file)?;
    let refused = |error| Failure::Input(format!("{} cannot be imported: {error}", arguments.file.display()));
    if arguments.list {
        let contents = (format.contents)(&text).map_err(refused)?;
        drop(bar);
        list(&contents, out).map_err(Failure::standard_output)?;
        return Ok(Outcome::Done);
    }
    let arrangement = match arguments.arrangement {
        HarnessArrangement::Installed => Arrangement::Installed,
        HarnessArrangement::Board => Arrangement::Board,
        HarnessArrangement::Assembly => Arrangement::Assembly,
    };
    let options = Options {
        max_segment: arguments.spacing.unwrap_or(Options::default().max_segment),
        accuracy: arguments.spacing.is_none().then(|| arguments.accuracy.unwrap_or(ACCURACY)),
        arrangement,
        memory: memory(arguments, arrangement)?,
        order: order(arguments, arrangement)?,
        selection: match &arguments.variant {
            Some(name) => Selection::Variant(name.clone()),
            None if arguments.modules.is_empty() => Selection::All,
            None => Selection::Modules(arguments.modules.iter().map(|name| name.trim().to_owned()).collect()),
        },
        name: arguments.name.clone(),
        file: Some(source(&arguments.file, &text)),
    };
    let imported = (format.import)(&text, &options).map_err(refused)?;
    drop(bar);
    let mut said: Vec<u8> = Vec::new();
    for finding in &imported.findings {
        said.extend(found(&finding.what, &finding.items, " at the end of the scenario").into_bytes());
    }
    uses(&imported.usage).print(&mut said).map_err(Failure::standard_output)?;
    // If standard error is closed, the import goes on.
    let _ = io::stderr().write_all(&said);
    match &arguments.output {
        None => out.write_all(imported.scenario.as_bytes()).map_err(Failure::standard_output)?,
        Some(path) => folder::write(path, |file| file.write_all(imported.scenario.as_bytes()))?,
    }
    let target = arguments.output.as_deref().unwrap_or(Path::new("standard output"));
    let bar = Bar::new(format!("checking {}", target.display()), true);
    let loaded = wireloom::load(&imported.scenario, &wireloom::registry());
    drop(bar);
    match loaded {
        Ok((_, built)) => {
            if let Some(path) = &arguments.output {
                writeln!(out, "wrote {} ({})", path.display(), size::words(&built.network))
                    .map_err(Failure::standard_output)?;
            }
            Ok(Outcome::Done)
        }
        Err(faults) => Err(Failure::Refused(vec![load::refusal(target, imported.scenario, faults)])),
    }
}

/// What became of the elements of the file.
fn uses(usage: &[Usage]) -> Columns {
    let mut table = Columns::new([
        "element of the file",
        ">number",
        ">used",
        ">named, without effect",
        ">of other modules",
        ">not read",
    ]);
    for own in usage {
        let numbers = [own.total, own.used, own.kept, own.left_out, own.not_read].map(|number| number.to_string());
        table.row(std::iter::once(own.kind.clone()).chain(numbers));
    }
    table
}

/// Modules and variants of a harness.
fn list(contents: &Contents, out: &mut dyn Write) -> io::Result<()> {
    let text = |text: &Option<String>| text.clone().unwrap_or_default();
    let mut modules = Columns::new(["module", ">parts", "option code", "description"]);
    for module in &contents.modules {
        let parts = module.parts.to_string();
        modules.row([module.name.clone(), parts, text(&module.option_code), text(&module.description)]);
    }
    modules.print(out)?;
    let mut variants = Columns::new(["variant", ">modules"]);
    for variant in &contents.variants {
        variants.row([variant.name.clone(), variant.modules.len().to_string()]);
    }
    variants.print(out)?;
    if contents.modules.is_empty() {
        writeln!(out, "the harness has no modules")?;
    }
    Ok(())
}

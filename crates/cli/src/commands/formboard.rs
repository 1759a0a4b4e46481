//! `wireloom formboard`: the harness flat, its drawings, and a scenario of it.

use super::import::{ACCURACY, HarnessFormat, source};
use crate::arguments::values::too_large;
use crate::arguments::{FormboardArguments, Paper};
use crate::failure::{Failure, Outcome};
use crate::files::folder::Folder;
use crate::files::load::{self, Beside};
use crate::plugin::trust::Trust;
use crate::print::progress::Bar;
use crate::print::text::{counted, found, printable};
use crate::size;
use std::io::{self, Write};
use std::path::Path;
use wireloom::formboard::drawing::{self, Table};
use wireloom::formboard::{Formboard, NoFormboard, Note, Options, Wishes, formboard as lay, wire_types};
use wireloom::import::kbl;
use wireloom::scenario::{Files, NoFiles, Scenario};
use wireloom::{Built, Registry};

/// The scenario of the harness on the board.
const SCENARIO: &str = "board.toml";

/// A harness as it is read.
struct Source {
    text: String,
    scenario: Scenario,
    /// All kinds that the scenario may name.
    registry: Registry,
    files: Box<dyn Files>,
    /// Wires one by one, of a file of another format.
    wires: Option<Vec<kbl::WireRun>>,
    /// Irregularities of such a file.
    findings: Vec<kbl::Finding>,
    /// Whether the scenario names other files.
    names_others: bool,
}

/// Lays the harness, and writes everything about the board.
pub fn formboard(arguments: &FormboardArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let FormboardArguments { file, output, board, gap, margin, paper, memory, .. } = arguments;
    let source = read(arguments)?;
    let bar = Bar::new(format!("laying {}", file.display()), true);
    let wishes = Wishes { board: Options { gap: *gap, margin: *margin, board: *board }, memory: *memory };
    let made = lay(&source.text, source.files.as_ref(), &source.registry, &wishes).map_err(|reason| match reason {
        NoFormboard::Faults(faults) => Failure::Refused(vec![load::refusal(file, source.text.clone(), faults)]),
        NoFormboard::Board(error) => Failure::Input(format!("{}: {error}{}", file.display(), help(&error))),
        other @ NoFormboard::Memory { .. } => Failure::Input(format!("--memory: {other}")),
    })?;
    too_large(made.board.size).map_err(|reason| {
        let cure = "leave branches out, or give a smaller --board, on which they are bent";
        Failure::Input(format!("{}: {reason}\n  help: {cure}", file.display()))
    })?;
    let checked = check(&made, &source)?;
    drop(bar);
    let tables = tables(&source, &made)?;
    let drawn = made.drawing(&tables);
    let mut notes = made.notes.clone();
    let unknown = drawing::not_printable(&drawn);
    if !unknown.is_empty() {
        let what = "characters that the fonts of PDF do not have; board.pdf has ? in their place";
        notes.push(Note { what: what.to_owned(), items: unknown.into_iter().map(|c| format!("`{c}`")).collect() });
    }
    let of_file = source.findings.iter().map(|own| found(&own.what, &own.items, " at the end of board.toml"));
    let notes: String = of_file.chain(notes.iter().map(|own| found(&own.what, &own.items, ""))).collect();
    // If standard error is closed, the work goes on.
    let _ = io::stderr().write_all(notes.as_bytes());

    let mut folder = Folder::create(output)?;
    folder.clear()?;
    folder.write("board.svg", |file| drawing::svg(&drawn, file))?;
    folder.write("board.dxf", |file| drawing::dxf(&drawn, file).map_err(io::Error::other))?;
    let paper = match paper {
        Paper::A0 => drawing::Paper::A0,
        Paper::A1 => drawing::Paper::A1,
        Paper::A2 => drawing::Paper::A2,
        Paper::A3 => drawing::Paper::A3,
        Paper::A4 => drawing::Paper::A4,
    };
    folder.write("board.pdf", |file| file.write_all(&drawing::pdf(&drawn, paper)))?;
    folder.write(SCENARIO, |file| file.write_all(made.scenario.as_bytes()))?;
    print(&made, &checked, &source, file, folder.path(), out).map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

/// Reads a scenario, or a harness file of another format.
fn read(arguments: &FormboardArguments) -> Result<Source, Failure> {
    let FormboardArguments { file, variant, allowed, .. } = arguments;
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match (extension.as_str(), HarnessFormat::of(file)) {
        ("toml", _) => {
            if variant.is_some() {
                return Err(Failure::Input(format!(
                    "--variant chooses modules of a KBL or VEC file; {} is a scenario, which has none",
                    file.display()
                )));
            }
            let loaded = load::scenario(file, &[], &Trust::to_check(allowed))?;
            let names_others = loaded.texts.len() > 1 || !loaded.hashed.is_empty() || !loaded.plugins.is_empty();
            let text = loaded.texts.into_iter().next().map(|(_, text)| text).unwrap_or_default();
            let (scenario, registry) = (loaded.scenario, loaded.registry);
            Ok(Source {
                text,
                scenario,
                registry,
                files: Box::new(Beside::of(file)),
                wires: None,
                findings: Vec::new(),
                names_others,
            })
        }
        (_, Some(format)) => {
            let text = load::text(file)?;
            let selection = variant.clone().map_or(kbl::Selection::All, kbl::Selection::Variant);
            let from = Some(source(file, &text));
            let mut options =
                kbl::Options { accuracy: Some(ACCURACY), selection, file: from, ..kbl::Options::default() };
            let mut imported = (format.import)(&text, &options);
            if matches!(imported, Err(kbl::ImportError::NoGeometry { .. })) {
                // Its lengths are enough for a board.
                options.arrangement = kbl::Arrangement::Board;
                imported = (format.import)(&text, &options);
            }
            let refused = |error| Failure::Input(format!("{} cannot be imported: {error}", file.display()));
            let imported = imported.map_err(refused)?;
            let registry = wireloom::registry();
            let loaded = wireloom::load(&imported.scenario, &registry);
            let (scenario, _) = loaded
                .map_err(|faults| Failure::Refused(vec![load::refusal(file, imported.scenario.clone(), faults)]))?;
            let (text, wires, findings) = (imported.scenario, Some(imported.wires), imported.findings);
            Ok(Source { text, scenario, registry, files: Box::new(NoFiles), wires, findings, names_others: false })
        }
        (_, None) => Err(Failure::Input(format!(
            "{}: a formboard is made of a scenario (.toml), a KBL file (.kbl, .xml) or a VEC file (.vec), not of \
             `.{extension}`",
            file.display()
        ))),
    }
}

fn help(error: &wireloom::formboard::Error) -> &'static str {
    match error {
        wireloom::formboard::Error::TooSmall { .. } => {
            "\n  help: give a larger --board, a smaller --margin or --gap, or leave --board out"
        }
        _ => "",
    }
}

/// The scenario on the board is checked as by `wireloom check`.
fn check(made: &Formboard, source: &Source) -> Result<Built, Failure> {
    match wireloom::load_with_files(&made.scenario, source.files.as_ref(), &source.registry) {
        Ok((_, built)) => Ok(built),
        Err(faults) => Err(Failure::Refused(vec![load::refusal(Path::new(SCENARIO), made.scenario.clone(), faults)])),
    }
}

fn tables(source: &Source, made: &Formboard) -> Result<Vec<Table>, Failure> {
    let (harness, board) = (&made.harness, &made.board);
    let mut tables = vec![drawing::parts(harness, board), drawing::branches(harness, board)];
    if let Some(wires) = &source.wires {
        let mut table = Table::new("Wires", &["wire", "from", "to", ">copper [mm²]", ">diameter [mm]", ">length [mm]"]);
        for wire in wires {
            let number = |value: Option<f64>, scale: f64, digits: usize| {
                value.map(|value| format!("{:.digits$}", value * scale)).unwrap_or_default()
            };
            let from = wire.ends.first().cloned().unwrap_or_default();
            let to = wire.ends.get(1..).unwrap_or_default().join(", ");
            let [copper, diameter] = [number(wire.copper_area, 1e6, 2), number(wire.diameter, 1e3, 2)];
            table.rows.push(vec![wire.name.clone(), from, to, copper, diameter, number(Some(wire.length), 1e3, 1)]);
        }
        tables.push(table);
    }
    let types = wire_types(&source.text, &source.scenario);
    tables.push(types.map_err(|fault| {
        Failure::Refused(vec![load::refusal(Path::new(SCENARIO), source.text.clone(), vec![fault])])
    })?);
    Ok(tables)
}

fn print(
    made: &Formboard,
    checked: &Built,
    source: &Source,
    file: &Path,
    folder: &Path,
    out: &mut dyn Write,
) -> io::Result<()> {
    let board = &made.board;
    let [width, height] = board.size.map(|x| x * 1e3);
    let sheets = board.sheets.map(|[columns, rows]| format!(", {columns} x {rows} sheets A0")).unwrap_or_default();
    let bent = board.lines.iter().filter(|line| line.curvature != 0.0).count();
    let length: f64 = board.lines.iter().map(|line| line.length).sum();
    writeln!(
        out,
        "{}: {}, {length:.2} m of cable, on a board of {width:.0} mm x {height:.0} mm{sheets}",
        printable(&made.name),
        counted(board.lines.len(), "branch", "branches"),
    )?;
    let pegs = counted(board.pegs.len(), "peg", "pegs");
    writeln!(
        out,
        "{pegs}, {} bent, {}",
        counted(bent, "branch", "branches"),
        counted(board.cuts.len(), "cut", "cuts")
    )?;
    writeln!(
        out,
        "wrote {}: board.svg, board.dxf, board.pdf, {SCENARIO} ({})",
        folder.display(),
        size::words(&checked.network)
    )?;
    if source.names_others {
        writeln!(
            out,
            "{SCENARIO} names files as {} does, from its own folder: move it there to run it",
            file.display()
        )?;
    }
    Ok(())
}

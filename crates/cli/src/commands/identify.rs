//! `wireloom identify`: numbers of a scenario from measured points.

use crate::arguments::IdentifyArguments;
use crate::failure::{Failure, Outcome};
use crate::files::folder::Folder;
use crate::files::load::{self, Beside};
use crate::interrupt;
use crate::plugin::trust::Trust;
use crate::print::identified;
use std::io::{self, Write};
use std::path::PathBuf;
use wireloom::Registry;
use wireloom::export::picture::{MeasuredCurve, MeasuredShape, write_curves, write_measured};
use wireloom::geometry::Vector;
use wireloom::identify::{self, Identified, NoFit, Request, Wishes};
use wireloom::scenario::value_for;
use wireloom::sensitivity::Source;

/// Identifies numbers of a scenario, prints them, and writes the files of the answer.
pub fn identify(arguments: &IdentifyArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let IdentifyArguments { file, shapes, bending, noise, json, out: path, allowed, .. } = arguments;
    // After a comma there may be a space.
    let fit: Vec<String> = arguments.fit.iter().map(|key| key.trim().to_owned()).collect();
    let loaded = load::scenario(file, &[], &Trust::to_run(allowed))?;
    let text = loaded.texts[0].1.as_str();
    let values = Values { text, registry: &loaded.registry };
    let priors = values.pairs(&arguments.prior, "--prior KEY=VALUE,DEVIATION")?;
    let bounds = values.pairs(&arguments.bounds, "--bounds KEY=MIN,MAX")?;
    let smooth = arguments.smooth.iter().map(|given| values.smoothness(given)).collect::<Result<Vec<_>, _>>()?;
    let measured = if bending.is_empty() { shapes } else { bending };
    let tables = measured.iter().map(|path| load::text(path)).collect::<Result<Vec<_>, _>>()?;
    let all: Vec<&str> = tables.iter().map(String::as_str).collect();
    let folder = path.as_deref().map(Folder::create).transpose()?;
    let files = Beside::of(file);
    interrupt::listen();
    let source = Source { monitor: interrupt::monitor().clone(), ..Source::new(text, &files, &loaded.registry) };
    let wishes = Wishes { fit: &fit, priors: &priors, bounds: &bounds, smooth: &smooth };
    let (points, curves): (&[&str], &[&str]) = if bending.is_empty() { (&all, &[]) } else { (&[], &all) };
    let request = Request { tables: points, bending: curves, wishes, noise: *noise };
    let found = match identify::identify(source, &request) {
        Ok(found) => found,
        Err(NoFit::Faults(faults)) => {
            return Err(Failure::Refused(vec![load::refusal(file, text.to_owned(), faults)]));
        }
        Err(NoFit::Table(k, faults)) => {
            return Err(Failure::Refused(vec![load::refusal(&measured[k], tables[k].clone(), faults)]));
        }
        Err(NoFit::Part(fault)) => return Err(Failure::Part(fault)),
        Err(refused @ NoFit::Question(_)) => return Err(Failure::Input(refused.to_string())),
        Err(none @ (NoFit::NoStart { .. } | NoFit::Stopped)) => {
            // Standard output is for the answer alone.
            let _ = writeln!(io::stderr(), "{none}");
            return Ok(Outcome::NotConverged);
        }
    };
    if let Some(folder) = folder {
        write(&found, measured, folder)?;
    }
    let printed = if *json {
        serde_json::to_writer_pretty(&mut *out, &found).map_err(io::Error::from).and_then(|()| writeln!(out))
    } else {
        identified::print(&found, measured, out)
    };
    printed.map_err(Failure::standard_output)?;
    Ok(if found.is_complete() { Outcome::Done } else { Outcome::NotConverged })
}

/// The files of the answer.
fn write(found: &Identified, measured: &[PathBuf], mut folder: Folder) -> Result<(), Failure> {
    folder.clear()?;
    folder.write("identified.json", |out| {
        serde_json::to_writer_pretty(&mut *out, found)?;
        writeln!(out)
    })?;
    folder.write("fitted.toml", |out| {
        for line in identified::remarks(found) {
            writeln!(out, "# {line}")?;
        }
        out.write_all(found.text.as_bytes())
    })?;
    if !found.curves.is_empty() {
        let curves = curves(found, measured);
        return folder
            .write("curves.svg", |out| write_curves(&curves, &format!("{}, identified", found.scenario), out));
    }
    let shapes = shapes(found);
    folder.write("shapes.svg", |out| write_measured(&shapes, &format!("{}, identified", found.scenario), out))
}

/// Measured and computed bending curves.
fn curves(found: &Identified, measured: &[PathBuf]) -> Vec<MeasuredCurve> {
    let curve = |own: &identify::Curve| MeasuredCurve {
        words: format!("{}: {:.1} % rms", measured[own.table].display(), 1e2 * own.relative),
        measured: own.samples.iter().map(|own| [1e3 * own.deflection, own.measured]).collect(),
        computed: own.computed.iter().map(|[deflection, load]| [1e3 * deflection, *load]).collect(),
    };
    found.curves.iter().map(curve).collect()
}

/// Measured and computed shapes of each configuration.
fn shapes(found: &Identified) -> Vec<MeasuredShape<'_>> {
    let of_configuration = |own: &identify::Configuration| {
        let step = found.ends.iter().find(|end| end.name == own.step)?;
        let points = own.points.iter().map(|point| {
            let computed = Vector::from(point.computed);
            // What was not measured is drawn where it was computed.
            let measured = Vector::from_fn(|i, _| point.measured[i].unwrap_or(computed[i]));
            [measured, computed]
        });
        let words = format!("{}: mean distance {:.1} mm", own.name, 1e3 * own.mean_distance);
        Some(MeasuredShape { words, step, points: points.collect() })
    };
    found.configurations.iter().filter_map(of_configuration).collect()
}

/// Reads values that are given for keys of a scenario.
struct Values<'s> {
    text: &'s str,
    registry: &'s Registry,
}

impl Values<'_> {
    fn value(&self, key: &str, given: &str) -> Result<f64, Failure> {
        let value = value_for(self.text, key, given.trim(), self.registry);
        value.map_err(|fault| Failure::Input(format!("the value for `{key}`: {fault}")))
    }

    fn pairs(&self, all: &[String], form: &str) -> Result<Vec<(String, [f64; 2])>, Failure> {
        all.iter().map(|given| self.pair(given, form)).collect()
    }

    /// `KEY=A,B`.
    fn pair(&self, given: &str, form: &str) -> Result<(String, [f64; 2]), Failure> {
        let parts = given.rsplit_once('=').and_then(|(key, both)| Some((key.trim(), both.split_once(',')?)));
        let Some((key, (one, other))) = parts else {
            return Err(Failure::Input(format!(
                "`{given}`: write {form}, with two numbers, in SI units or with a unit"
            )));
        };
        Ok((key.to_owned(), [self.value(key, one)?, self.value(key, other)?]))
    }

    /// `KEY,KEY,...=DEVIATION`.
    fn smoothness(&self, given: &str) -> Result<(Vec<String>, f64), Failure> {
        let Some((keys, deviation)) = given.rsplit_once('=') else {
            let form = "--smooth KEY,KEY,...=DEVIATION, with a number in SI units or with a unit";
            return Err(Failure::Input(format!("`{given}`: write {form}")));
        };
        let keys: Vec<String> = keys.split(',').map(|key| key.trim().to_owned()).collect();
        let deviation = self.value(&keys[0], deviation)?;
        Ok((keys, deviation))
    }
}

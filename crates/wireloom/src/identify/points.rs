//! Reads tables of measured points.

use super::table::{self, fault};
use csv::StringRecord;
use wireloom_core::Vector;
use wireloom_scenario::Fault;
use wireloom_scenario::fault::did_you_mean;

/// The columns of a table; in place of `marker`, or beside it, there may be [`PLACE`].
pub const COLUMNS: [&str; 5] = ["configuration", "marker", "x", "y", "z"];
/// Columns that name a place of the harness: a branch and the unstressed arc length (m) on it.
pub const PLACE: [&str; 2] = ["branch", "s"];
/// Distance of a point from the origin, in lengths of the whole harness and its distance from there, that no cable
/// reaches.
const OUT_OF_REACH: f64 = 3.0;

/// Where a measured point is on the harness.
#[derive(Clone, Debug, PartialEq)]
pub enum MeasuredPlace {
    /// At one of `[[markers]]`, or at a joint.
    Named,
    /// At a free end.
    End,
    /// On a branch, at an unstressed arc length, m.
    Along(String, f64),
}

/// A measured point.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredPoint {
    /// Name of the configuration.
    pub configuration: String,
    /// Index of the step.
    pub step: usize,
    /// Name of the marker, joint or end, or words for a place on a branch.
    pub marker: String,
    /// Where it is.
    pub place: MeasuredPlace,
    /// Coordinates, m; `None`: not measured.
    pub position: [Option<f64>; 3],
    /// Bytes of its line.
    pub line: std::ops::Range<usize>,
}

/// What a table may name.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    /// Names of the steps.
    pub steps: &'a [String],
    /// Names of markers and joints.
    pub markers: &'a [String],
    /// Names of free ends.
    pub ends: &'a [String],
    /// Names and lengths (m) of branches.
    pub branches: &'a [(String, f64)],
    /// Length of all branches together and distance of their ends from the origin, m.
    pub reach: f64,
}

/// Reads a table with the columns `configuration, marker, x, y, z`, in any order: coordinates in m. A marker is one of
/// the scenario, a joint or an end; the columns `branch, s` name other places. An empty cell is a coordinate that was
/// not measured; lines that begin with `#` are comments.
///
/// # Errors
/// All faults, with their places in the text.
pub fn read(text: &str, names: Names<'_>) -> Result<Vec<MeasuredPoint>, Vec<Fault>> {
    let table = table::read(text, HELP)?;
    let columns = columns(&table.headers, table.header_line)?;
    let (mut points, mut faults) = (Vec::new(), table.faults);
    for (line, record) in &table.records {
        match point(record, &columns, line, names) {
            Ok(point) => points.push(point),
            Err(more) => faults.extend(more),
        }
    }
    if points.is_empty() && faults.is_empty() {
        faults.push(fault(0..0, "the table has no points".to_owned(), HELP.to_owned()));
    }
    if faults.is_empty() { Ok(points) } else { Err(faults) }
}

/// Help where the form of the table is wrong.
const HELP: &str = "write the line `configuration,marker,x,y,z`, then one line for each measured point, in m";

/// Indices of the columns.
struct Columns {
    configuration: usize,
    marker: Option<usize>,
    place: Option<[usize; 2]>,
    coordinates: [usize; 3],
}

fn columns(headers: &StringRecord, line: std::ops::Range<usize>) -> Result<Columns, Vec<Fault>> {
    let mut faults = Vec::new();
    let known = |header: &&str| COLUMNS.contains(header) || PLACE.contains(header);
    for header in headers.iter().filter(|header| !known(header)) {
        let help = match header.chars().next() {
            Some(axis @ ('x' | 'y' | 'z')) => format!("give coordinates in m, under the name `{axis}`"),
            _ => format!("the columns are {}, or `branch,s` for `marker`, separated by commas", COLUMNS.join(", ")),
        };
        faults.push(fault(line.clone(), format!("there is no column `{header}` in a table of measured points"), help));
    }
    let mut place = |name: &str, needed: bool| {
        let found: Vec<usize> = (0..headers.len()).filter(|k| &headers[*k] == name).collect();
        match found.len() {
            0 if needed => {
                faults.push(fault(line.clone(), format!("the column `{name}` is missing"), HELP.to_owned()));
            }
            0 | 1 => {}
            n => faults.push(fault(line.clone(), format!("the column `{name}` is there {n} times"), HELP.to_owned())),
        }
        found.first().copied()
    };
    let on_branches = PLACE.iter().any(|name| headers.iter().any(|header| header == *name));
    let branch = PLACE.map(|name| place(name, on_branches));
    let marker = place("marker", !on_branches);
    let [configuration, x, y, z] = ["configuration", "x", "y", "z"].map(|name| place(name, true).unwrap_or(0));
    let branch = branch[0].zip(branch[1]).map(|(branch, s)| [branch, s]);
    let columns = Columns { configuration, marker, place: branch, coordinates: [x, y, z] };
    if faults.is_empty() { Ok(columns) } else { Err(faults) }
}

/// The place that a line names, with its name; a fault as message and help.
fn place(marker: &str, branch: &str, s: &str, names: Names<'_>) -> Result<(String, MeasuredPlace), (String, String)> {
    let known = |all: &[String]| all.iter().any(|own| own == marker);
    match (marker.is_empty(), branch.is_empty() && s.is_empty()) {
        (false, true) if known(names.markers) => Ok((marker.to_owned(), MeasuredPlace::Named)),
        (false, true) if known(names.ends) => Ok((marker.to_owned(), MeasuredPlace::End)),
        (false, true) => {
            let all = names.markers.iter().chain(names.ends).map(String::as_str);
            let known = did_you_mean(marker, all);
            let help = "add [[markers]] with this name to the scenario, name one that is there, or name the place in \
                        columns `branch,s`";
            Err((format!("the scenario has no marker, joint or end `{marker}`: {known}"), help.to_owned()))
        }
        (true, false) => {
            let Some((_, length)) = names.branches.iter().find(|(own, _)| own == branch) else {
                let known = did_you_mean(branch, names.branches.iter().map(|(own, _)| own.as_str()));
                return Err((format!("the scenario has no branch `{branch}`: {known}"), "name a branch".to_owned()));
            };
            match s.parse::<f64>() {
                Ok(s) if (0.0..=*length).contains(&s) => {
                    Ok((format!("{branch} at {s} m"), MeasuredPlace::Along(branch.to_owned(), s)))
                }
                Ok(_) => {
                    let help = format!("give the arc length in m, from 0 to {length}");
                    Err((format!("s = {s} m is not on the branch `{branch}`"), help))
                }
                Err(_) => {
                    let help = "give the arc length in m, without a unit";
                    Err((format!("s = `{s}` is not a number"), help.to_owned()))
                }
            }
        }
        (true, true) => Err(("this line names no place".to_owned(), "name a marker, or a branch and s".to_owned())),
        (false, false) => Err((
            format!("this line names the marker `{marker}` and the place `{branch}`, `{s}`"),
            "leave one of them empty".to_owned(),
        )),
    }
}

fn point(
    record: &StringRecord,
    columns: &Columns,
    line: &std::ops::Range<usize>,
    names: Names<'_>,
) -> Result<MeasuredPoint, Vec<Fault>> {
    let mut faults = Vec::new();
    let mut refuse = |message: String, help: String| faults.push(fault(line.clone(), message, help));
    let cell = |k: usize| record.get(k).unwrap_or_default();
    let configuration = cell(columns.configuration);
    let [x, y, z] = columns.coordinates.map(cell);
    let step = match names.steps.iter().position(|step| step == configuration) {
        Some(step) => step,
        None if names.steps.len() == 1 => 0,
        None => {
            let known = did_you_mean(configuration, names.steps.iter().map(String::as_str));
            refuse(format!("the scenario has no step `{configuration}`: {known}"), "name a step".to_owned());
            0
        }
    };
    let [branch, s] = columns.place.map_or([""; 2], |place| place.map(cell));
    let (marker, place) = match place(columns.marker.map_or("", cell), branch, s, names) {
        Ok(found) => found,
        Err((message, help)) => {
            refuse(message, help);
            (String::new(), MeasuredPlace::Named)
        }
    };
    let mut coordinate = |cell: &str, axis: &str| -> Option<f64> {
        if cell.is_empty() {
            return None;
        }
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() && value.abs() > OUT_OF_REACH * names.reach => {
                let message = format!("{axis} = {cell} m is farther than the harness reaches ({:.3} m)", names.reach);
                refuse(message, "give coordinates in m, in the axes of the scenario".to_owned());
                None
            }
            Ok(value) if value.is_finite() => Some(value),
            _ => {
                let help = "write a number in m, without a unit; leave the cell empty where nothing was measured";
                refuse(format!("{axis} = `{cell}` is not a finite number"), help.to_owned());
                None
            }
        }
    };
    let position = [coordinate(x, "x"), coordinate(y, "y"), coordinate(z, "z")];
    if faults.is_empty() && position.iter().all(Option::is_none) {
        faults.push(fault(
            line.clone(),
            format!("`{marker}` has no coordinate in `{configuration}`"),
            "leave the line out where nothing was measured".to_owned(),
        ));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    Ok(MeasuredPoint { configuration: configuration.to_owned(), step, marker, place, position, line: line.clone() })
}

impl MeasuredPoint {
    /// Number of coordinates that were measured.
    pub fn coordinates(&self) -> usize {
        self.position.iter().flatten().count()
    }

    /// Computed minus measured position in the coordinates that were measured.
    pub fn residuals(&self, computed: &Vector) -> impl Iterator<Item = f64> {
        let computed = [computed.x, computed.y, computed.z];
        self.position.into_iter().zip(computed).filter_map(|(measured, computed)| Some(computed - measured?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reads(text: &str) -> Result<Vec<MeasuredPoint>, Vec<(usize, String)>> {
        let (steps, markers) = (["hang".to_owned(), "bend".to_owned()], ["m1".to_owned(), "m2".to_owned()]);
        let (ends, branches) = (["tip".to_owned()], [("arm".to_owned(), 0.5)]);
        let names = Names { steps: &steps, markers: &markers, ends: &ends, branches: &branches, reach: 1.5 };
        read(text, names)
            .map_err(|faults| faults.into_iter().map(|fault| (fault.position(text).0, fault.message)).collect())
    }

    #[test]
    fn columns_come_in_any_order_and_cells_may_be_empty() {
        let text =
            "\u{feff}# by hand\nmarker, x, y, z, configuration\n\n m2 ,0.1, ,-2e-1,bend\n# late\nm1,0,0,1,hang\n";
        let points = reads(text).expect("no faults");
        assert_eq!(points.len(), 2);
        assert_eq!((points[0].step, &*points[0].marker, points[0].position), (1, "m2", [Some(0.1), None, Some(-0.2)]));
        assert_eq!(&text[points[1].line.clone()], "m1,0,0,1,hang");
        let residuals: Vec<f64> = points[0].residuals(&Vector::new(0.2, 9.0, 0.0)).collect();
        assert_eq!(residuals, [0.1, 0.2]);
    }

    #[test]
    fn faults_have_their_lines() {
        let says = |text: &str, line: usize, words: &str| {
            let faults = reads(text).expect_err("a fault");
            assert!(faults.iter().any(|(at, said)| *at == line && said.contains(words)), "{faults:?}");
        };
        says("configuration,marker,x_mm,y,z\nhang,m1,1,2,3\n", 1, "no column `x_mm`");
        says("configuration,marker,x,y\nhang,m1,1,2\n", 1, "`z` is missing");
        says("configuration;marker;x;y;z\n", 1, "no column `configuration;marker;x;y;z`");
        let table = |row: &str| format!("configuration,marker,x,y,z\nhang,m1,0,0,0\n{row}\n");
        says(&table("hnag,m1,0,0,0"), 3, "no step `hnag`: did you mean `hang`?");
        says(&table("hang,m3,0,0,0"), 3, "no marker, joint or end `m3`");
        says(&table("hang,,0,0,0"), 3, "names no place");
        let on_branches = |row: &str| format!("configuration,branch,s,x,y,z\n{row}\n");
        says(&on_branches("hang,amr,0.1,0,0,0"), 2, "no branch `amr`: did you mean `arm`?");
        says(&on_branches("hang,arm,0.6,0,0,0"), 2, "s = 0.6 m is not on the branch `arm`");
        says(&on_branches("hang,arm,1 mm,0,0,0"), 2, "s = `1 mm` is not a number");
        says("configuration,branch,x,y,z\nhang,arm,0,0,0\n", 1, "the column `s` is missing");
        says(&table("hang,m1,0,0"), 3, "this line has 4 cells, the header has 5");
        says(&table("hang,m1,0,0,nan"), 3, "z = `nan` is not a finite number");
        says(&table("hang,m1,0,12 mm,0"), 3, "y = `12 mm` is not a finite number");
        says(&table("hang,m1,0,0,-345"), 3, "farther than the harness reaches");
        says(&table("hang,m1,,,"), 3, "`m1` has no coordinate");
        says("configuration,marker,x,y,z\n", 1, "no points");
        says("", 1, "is missing");
    }

    #[test]
    fn places_are_markers_ends_or_on_branches() {
        let points = reads("configuration,marker,branch,s,x,y,z\nhang,tip,,,0,0,0\nhang,,arm,0.25,0,0,0\n");
        let places: Vec<(String, MeasuredPlace)> =
            points.expect("no faults").into_iter().map(|point| (point.marker, point.place)).collect();
        let along = MeasuredPlace::Along("arm".to_owned(), 0.25);
        assert_eq!(places, [("tip".to_owned(), MeasuredPlace::End), ("arm at 0.25 m".to_owned(), along)]);
    }

    #[test]
    fn any_configuration_is_the_only_step() {
        let (steps, markers) = (["equilibrium".to_owned()], ["m1".to_owned()]);
        let names = Names { steps: &steps, markers: &markers, ends: &[], branches: &[], reach: 1.5 };
        let points = read("configuration,marker,x,y,z\nloop 1,m1,0,0,0\n", names).expect("no faults");
        assert_eq!((points[0].step, &*points[0].configuration), (0, "loop 1"));
    }
}

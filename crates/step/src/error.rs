//! Errors of reading a STEP file.

use std::io;
use std::path::PathBuf;

/// What Python needs, as pip installs it.
pub const REQUIRED: &str = "cadquery-ocp-novtk>=8";

/// Environment variable with the folder of the cache.
pub(crate) const CACHE: &str = "WIRELOOM_CACHE";
/// That folder in the user's home, where the variable names none.
pub(crate) const CACHE_AT_HOME: &str = ".wireloom/cache";

/// Error of reading a STEP file. Lines count from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// There is nothing in it.
    #[error("the file is empty")]
    Empty,
    /// It does not begin as a STEP file does.
    #[error("it is no STEP file: it begins with `{found}`, not with `ISO-10303-21;`")]
    NotStep {
        /// Its first characters.
        found: String,
    },
    /// Its end is missing.
    #[error("it is cut off: it ends with `{found}`, not with `END-ISO-10303-21;`")]
    Truncated {
        /// Its last line.
        line: usize,
        /// Its last characters.
        found: String,
    },
    /// It does not follow the syntax, or refers to what is not there.
    #[error("{said}")]
    Faulty {
        /// The line, where Open CASCADE says one.
        line: Option<usize>,
        /// What it says.
        said: String,
    },
    /// It says no unit of length.
    #[error("it says no unit of length (`LENGTH_UNIT`), so its size is not known")]
    NoUnit {
        /// Line of a context without one.
        line: usize,
    },
    /// It has no shapes, or they have no solids.
    #[error("it has no solids")]
    NoSolids,
    /// A part has nothing at all.
    #[error("part \"{part}\" has no shape: Open CASCADE could make none of what the file says")]
    NoShape {
        /// Name of the part.
        part: String,
    },
    /// Faces of parts do not enclose a solid.
    #[error("{}", .parts.iter().map(open_part).collect::<Vec<_>>().join("; "))]
    OpenShell {
        /// Names of the parts, and numbers of faces.
        parts: Vec<(String, usize)>,
    },
    /// The triangles of a solid are not what it is.
    #[error(
        "part \"{part}\" loses its shape: with a deflection of {} mm its triangles have {:.0} % of its volume",
        .deflection * 1e3,
        .share * 100.0
    )]
    Vanished {
        /// Name of the part.
        part: String,
        /// Largest distance from the surface that was asked for, m.
        deflection: f64,
        /// Volume of the triangles over that of the solid.
        share: f64,
        /// A deflection that may do, m.
        right: f64,
    },
    /// The triangles of a solid are not its surface.
    #[error("part \"{part}\": {reason}")]
    NoSurface {
        /// Name of the part.
        part: String,
        /// What is wrong.
        reason: String,
    },
    /// A part is placed as no rigid body can be.
    #[error("\"{name}\" is mirrored or scaled where it is placed")]
    NotRigid {
        /// Its name.
        name: String,
    },
    /// No deflection.
    #[error("a deflection of {value} mm is not above zero")]
    Deflection {
        /// What was given, mm.
        value: f64,
    },
    /// A pattern of parts fits none.
    #[error("the pattern \"{pattern}\" fits no part")]
    NoMatch {
        /// The pattern.
        pattern: String,
        /// Names that there are.
        names: Vec<String>,
    },
    /// The patterns fit all parts.
    #[error("all {count} parts are left out")]
    NothingLeft {
        /// Number of parts.
        count: usize,
    },
    /// There is no Python.
    #[error("the STEP file needs Python, and `{program}` cannot be started: {source}")]
    NoPython {
        /// The interpreter.
        program: String,
        /// The reason of the system.
        source: io::Error,
    },
    /// Python lacks Open CASCADE, or has an older one.
    #[error("the STEP file needs Open CASCADE, and `{program}` has {found}")]
    NoPackage {
        /// The interpreter.
        program: String,
        /// What it has.
        found: String,
    },
    /// It took too long.
    #[error("Open CASCADE has not read the file within {seconds} s, and was ended")]
    TimeLimit {
        /// Limit, s.
        seconds: u64,
    },
    /// The other process failed.
    #[error("Open CASCADE failed ({how}){}", after_colon(.said))]
    Crashed {
        /// How it ended.
        how: String,
        /// The last lines that it wrote.
        said: String,
    },
    /// Ctrl-C.
    #[error("interrupted")]
    Interrupted,
    /// A file could not be written or read.
    #[error("cannot {what} {}: {source}", .path.display())]
    Io {
        /// The operation.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// The reason of the system.
        source: io::Error,
    },
}

fn open_part((name, faces): &(String, usize)) -> String {
    let what = if *faces == 1 { "1 face that encloses".into() } else { format!("{faces} faces that enclose") };
    format!("part \"{name}\" is an open shell: it has {what} no solid")
}

fn after_colon(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!(": {text}") }
}

/// A number with two digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

impl StepError {
    /// The line of the file that it is about.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Empty | Self::NotStep { .. } => Some(1),
            Self::Truncated { line, .. } | Self::NoUnit { line } => Some(*line),
            Self::Faulty { line, .. } => *line,
            _ => None,
        }
    }

    /// Whether it is about the file or what was asked for, not about this machine.
    pub fn is_refusal(&self) -> bool {
        !matches!(self, Self::NoPython { .. } | Self::NoPackage { .. } | Self::Interrupted | Self::Io { .. })
    }

    /// Remedy.
    pub fn help(&self) -> String {
        let python = "another interpreter can be named in the environment variable WIRELOOM_PYTHON";
        match self {
            Self::Empty | Self::NotStep { .. } => "export the parts as STEP (AP203, AP214 or AP242)".into(),
            Self::Truncated { .. } => "copy or export the file again".into(),
            Self::Faulty { .. } => "the file is damaged: export it again".into(),
            Self::NoUnit { .. } => "export it again with a unit of length, such as millimetres".into(),
            Self::NoSolids => "contact needs solid bodies: export the parts as solids".into(),
            Self::OpenShell { parts } => {
                let without = parts.first().map_or("", |(name, _)| name);
                format!(
                    "contact needs solid bodies: close the shell where it is drawn, or leave the part out: wireloom \
                     import step --without \"{without}\""
                )
            }
            Self::Vanished { right, .. } => format!("give a smaller deflection, such as {} mm", rounded(right * 1e3)),
            Self::NoSurface { .. } => {
                "give a smaller deflection, repair the part where it is drawn, or leave it out: wireloom import step \
                 --without"
                    .into()
            }
            Self::NoShape { .. } => {
                "export the part again, such as by AP214, or leave it out: wireloom import step --without".into()
            }
            Self::NotRigid { .. } => "export the part as a shape of its own, or leave it out".into(),
            Self::Deflection { .. } => "give a length such as 0.1 mm".into(),
            Self::NoMatch { names, .. } => {
                const SHOWN: usize = 8;
                let shown: Vec<String> = names.iter().take(SHOWN).map(|name| format!("\"{name}\"")).collect();
                let more = names.len().saturating_sub(SHOWN);
                let more = if more > 0 { format!(", and {more} more") } else { String::new() };
                format!("its parts are {}{more}; * stands for any characters, ? for one", shown.join(", "))
            }
            Self::NothingLeft { .. } => "give patterns that fit only what is not needed".into(),
            Self::NoPython { .. } => {
                format!("install Python 3.10 or later, then: python3 -m pip install \"{REQUIRED}\"; {python}")
            }
            Self::NoPackage { program, .. } => format!("{program} -m pip install \"{REQUIRED}\"; {python}"),
            Self::TimeLimit { .. } => {
                "leave out what is not needed where the file is exported, give a larger deflection, or, to wireloom \
                 import step, a longer --time-limit; what it has read is then in the cache"
                    .into()
            }
            Self::Crashed { .. } => "export the file again, or part by part, to find what it fails on".into(),
            Self::Interrupted => "start again; what was read completely is in the cache".into(),
            Self::Io { .. } => {
                format!("the cache lies in ~/{CACHE_AT_HOME}, or where the environment variable {CACHE} says")
            }
        }
    }
}

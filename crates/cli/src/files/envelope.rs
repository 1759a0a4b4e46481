//! The tolerance envelope in the program's own folder of a sweep, for `wireloom studio --envelope DIR`.

use crate::failure::Failure;
use crate::files::own::Own;
use crate::files::saved::{decode, encode};
use std::path::Path;
use wireloom::geometry::Vector;
use wireloom::harness::Surface;
use wireloom::sweep::Tube;
use wireloom_studio::envelope;

/// Its name.
const ENVELOPE: &str = "envelope";
/// Help where it is damaged.
const HELP: &str = "carry out the sweep again";

/// Keeps the envelope of a sweep.
pub fn keep(own: &Own, tubes: &[Tube], surface: &Surface) -> Result<(), Failure> {
    encode(own, ENVELOPE, &(tubes, &surface.corners, &surface.triangles), false)
}

/// Removes that of an earlier sweep.
pub fn remove(own: &Own) -> Result<(), Failure> {
    own.remove(&[ENVELOPE], &[])
}

/// The envelope of the sweep in a folder, as pages read it.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let none = || {
        Failure::Input(format!(
            "{} has no envelope: it is the folder of a sweep that has ended, with `swept` in its [sweep]",
            path.display()
        ))
    };
    if !exists(path) {
        return Err(none());
    }
    let own = Own::open(path)?;
    let kept = decode::<(Vec<Tube>, Vec<Vector>, Vec<[u32; 3]>)>(&own, ENVELOPE, HELP)?;
    let (tubes, corners, triangles) = kept.ok_or_else(none)?;
    envelope::encode(&tubes, &Surface { corners, triangles })
        .ok_or_else(|| Failure::Input(format!("the envelope in {} is not one of this program; {HELP}", path.display())))
}

/// Whether a folder has the envelope of a sweep.
pub fn exists(path: &Path) -> bool {
    Own::open(path).is_ok_and(|own| own.place().has(ENVELOPE))
}

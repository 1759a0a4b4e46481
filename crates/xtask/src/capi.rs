//! The C library: builds and installs it.

use crate::run::{command, root, step, target};
use std::fs;
use std::io;
use std::path::Path;

/// Folder of the library's sources.
const SOURCES: &str = "crates/capi";
/// Number in the name of the shared library, as in `build.rs` there.
const SONAME: &str = "0";
/// Libraries of the system that the static one needs.
const LIBRARIES: &str = "-lgcc_s -lutil -lrt -lpthread -lm -ldl -lc";

/// Builds the library, and installs it with its headers into a folder: `[--debug] [FOLDER]`.
pub fn install(arguments: &[&str]) -> Result<(), String> {
    let (debug, folder) = match arguments {
        [] => (false, None),
        ["--debug"] => (true, None),
        ["--debug", folder] | [folder, "--debug"] => (true, Some(*folder)),
        [folder] => (false, Some(*folder)),
        _ => return Err("cargo xtask capi [--debug] [FOLDER]".to_owned()),
    };
    if !cfg!(target_os = "linux") {
        return Err("the C library is installed on Linux only so far".to_owned());
    }
    let folder = folder.map_or_else(|| target().join("capi"), |folder| root().join(folder));
    // With the features of the program the tests need no second build of the crates below.
    let profile: &[&str] = if debug { &["--package", "wireloom-cli"] } else { &["--release"] };
    let build = [&["build", "--quiet", "--package", "wireloom-capi"], profile].concat();
    step("the C library", &mut command("cargo", &build))?;
    let built = target().join(if debug { "debug" } else { "release" });
    copy(&built, &folder).map_err(|error| format!("the C library cannot be installed: {error}"))?;
    println!("   installed in {}", folder.display());
    Ok(())
}

/// Puts the library, its headers and what build systems read into a folder.
fn copy(built: &Path, folder: &Path) -> io::Result<()> {
    let (sources, version) = (root().join(SOURCES), env!("CARGO_PKG_VERSION"));
    let (library, include) = (folder.join("lib"), folder.join("include"));
    fs::create_dir_all(&include)?;
    fs::create_dir_all(&library)?;
    for header in ["wireloom.h", "wireloom.hpp"] {
        fs::copy(sources.join("include").join(header), include.join(header))?;
    }
    fs::copy(built.join("libwireloom_capi.a"), library.join("libwireloom.a"))?;
    // A program that runs keeps the old file.
    let shared = format!("libwireloom.so.{version}");
    remove(&library.join(&shared))?;
    fs::copy(built.join("libwireloom_capi.so"), library.join(&shared))?;
    for link in [format!("libwireloom.so.{SONAME}"), "libwireloom.so".to_owned()] {
        remove(&library.join(&link))?;
        symlink(&shared, &library.join(&link))?;
    }
    for (file, into) in [
        ("wireloom.pc", "pkgconfig"),
        ("wireloom-config.cmake", "cmake/wireloom"),
        ("wireloom-config-version.cmake", "cmake/wireloom"),
    ] {
        let text = fs::read_to_string(sources.join("install").join(file))?;
        let text = text.replace("@VERSION@", version).replace("@SONAME@", SONAME).replace("@LIBRARIES@", LIBRARIES);
        fs::create_dir_all(library.join(into))?;
        fs::write(library.join(into).join(file), text)?;
    }
    Ok(())
}

fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(unix)]
fn symlink(to: &str, link: &Path) -> io::Result<()> {
    std::os::unix::fs::symlink(to, link)
}

#[cfg(not(unix))]
fn symlink(_: &str, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

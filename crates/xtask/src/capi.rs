//! The C library: builds and installs it.

use crate::run::{as_tested, command, root, step, target};
use std::fs;
use std::io;
use std::path::Path;

/// Folder of the library's sources.
const SOURCES: &str = "crates/capi";
/// Number in the name of the shared library. It goes up when programs that were linked with an older one would break.
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
    if debug {
        as_tested("the C library")?;
    } else {
        step("the C library", &mut command("cargo", &["build", "--quiet", "--release", "--package", "wireloom-capi"]))?;
    }
    let library = target().join(if debug { "debug" } else { "release" }).join("libwireloom_capi.a");
    copy(&library, &folder).map_err(|error| format!("the C library cannot be installed: {error}"))?;
    link(&folder.join("lib"), debug)?;
    println!("   installed in {}", folder.display());
    Ok(())
}

/// Puts the static library, the headers, and what build systems read into a folder.
fn copy(library: &Path, folder: &Path) -> io::Result<()> {
    let (sources, version) = (root().join(SOURCES), env!("CARGO_PKG_VERSION"));
    let (into, include) = (folder.join("lib"), folder.join("include"));
    fs::create_dir_all(&include)?;
    for header in ["wireloom.h", "wireloom.hpp"] {
        fs::copy(sources.join("include").join(header), include.join(header))?;
    }
    for (file, folder) in [
        ("wireloom.pc", "pkgconfig"),
        ("wireloom-config.cmake", "cmake/wireloom"),
        ("wireloom-config-version.cmake", "cmake/wireloom"),
    ] {
        let text = fs::read_to_string(sources.join("install").join(file))?;
        let text = text.replace("@VERSION@", version).replace("@SONAME@", SONAME).replace("@LIBRARIES@", LIBRARIES);
        fs::create_dir_all(into.join(folder))?;
        fs::write(into.join(folder).join(file), text)?;
    }
    fs::copy(library, into.join("libwireloom.a")).map(|_| ())
}

/// Links the shared library from the static one in the same folder: with the functions of `wireloom.map` alone, and
/// their versions.
fn link(folder: &Path, debug: bool) -> Result<(), String> {
    let map = root().join(SOURCES).join("wireloom.map");
    let listed = fs::read_to_string(&map).map_err(|error| format!("{}: {error}", map.display()))?;
    let functions = listed.lines().map(|line| line.trim().trim_end_matches(';')).filter(|f| f.starts_with("wireloom_"));
    let shared = format!("libwireloom.so.{}", env!("CARGO_PKG_VERSION"));
    let path = folder.join(&shared);
    let place = |error: io::Error| format!("{}: {error}", folder.display());
    // A program that runs keeps the old file.
    remove(&path).map_err(place)?;
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    // Its threads live on when a host unloads it, so it stays.
    let mut link = command(&compiler, &["-shared", "-Wl,--gc-sections", "-Wl,-z,nodelete", "-Wl,-z,defs"]);
    link.args(functions.map(|function| format!("-Wl,-u,{function}")));
    link.arg(format!("-Wl,-soname,libwireloom.so.{SONAME}")).arg(format!("-Wl,--version-script={}", map.display()));
    link.args(if debug { None } else { Some("-Wl,--strip-all") });
    link.arg(folder.join("libwireloom.a")).args(LIBRARIES.split(' ')).arg("-o").arg(&path);
    let done = link.output().map_err(|error| format!("{compiler} cannot be run: {error}"))?;
    if !done.status.success() {
        return Err(format!("failed: link {shared}\n{}", String::from_utf8_lossy(&done.stderr)));
    }
    for name in [format!("libwireloom.so.{SONAME}"), "libwireloom.so".to_owned()] {
        remove(&folder.join(&name)).and_then(|()| symlink(&shared, &folder.join(&name))).map_err(place)?;
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

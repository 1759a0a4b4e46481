//! Shared parts of the whole-program tests: folders, the program, scenario texts, the hunt.

pub mod cables;
pub mod derivatives;
pub mod growth;
pub mod hunt;
pub mod imports;
pub mod place;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the repository").to_path_buf()
}

/// A folder of large input that lies beside the repository, or where `WIRELOOM_SHARED` says; it may be absent.
pub fn shared(name: &str) -> PathBuf {
    std::env::var_os("WIRELOOM_SHARED").map_or_else(|| root().join("../shared"), PathBuf::from).join(name)
}

/// Folder into which cargo has built the running test, such as `target/debug`.
fn profile_folder() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows where it is");
    test.ancestors().nth(2).expect("tests lie in <profile>/deps").to_path_buf()
}

/// The binary `wireloom`, built with the profile of the tests: what they see is what the sources say. Beside it lie the
/// plugins of the workspace.
///
/// # Panics
/// If it cannot be built.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let folder = profile_folder();
        let mut build = cargo();
        // One test among the targets: then all crates have the features that they have in `cargo test --workspace`, and
        // none is compiled twice.
        build.args(["build", "--quiet", "--workspace", "--lib", "--bin", "wireloom", "--test", "header"]);
        if folder.ends_with("release") {
            build.arg("--release");
        }
        assert!(build.status().is_ok_and(|status| status.success()), "the program cannot be built");
        folder.join("wireloom").with_extension(std::env::consts::EXE_EXTENSION)
    })
}

/// Cargo, in the repository and with the target folder of the tests.
pub fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo
        .current_dir(root())
        .env("CARGO_TARGET_DIR", profile_folder().parent().expect("a folder of the target folder"));
    cargo
}

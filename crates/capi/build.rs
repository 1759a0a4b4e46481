//! Gives the shared library its name on Linux: programs that were linked with one interface do not load another one.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        // The number goes up when the interface changes in a way that breaks programs.
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libwireloom.so.0");
    }
}

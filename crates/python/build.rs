//! Arguments of the linker where a Python module leaves the interpreter's symbols open (macOS).

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}

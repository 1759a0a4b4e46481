//! The writers, on results made by hand from analytic curves.

mod comparison_html;
mod comparisons;
mod csv_table;
#[cfg(feature = "arrow")]
mod fields_arrow;
mod gltf_files;
mod json_contract;
#[cfg(feature = "parquet")]
mod parquet_table;
mod picture_svg;
mod report_html;
mod samples;
mod vtk_files;

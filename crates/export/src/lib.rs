//! Results as JSON, CSV, VTK and pictures.

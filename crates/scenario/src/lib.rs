//! TOML text to checked scenario to network.

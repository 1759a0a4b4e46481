//! CPU minimisers, certificate and step driver.

//! Plugins in Rust: write kinds against [`core`], as the built-in ones are written, and [`export!`] them.
//!
//! `crates/plugin/README.md` is a guide for authors, in Rust and in C. [`abi`] has the C interface; authors in Rust do
//! not need it.
//!
//! A rod is written as its constitutive laws; the program lays them on the grid of the built-in rods:
//!
//! ```
//! use wireloom_plugin::core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, Past, Point, Response};
//! use wireloom_plugin::core::registry::ConstitutiveKind;
//! use wireloom_plugin::core::{Matrix, Vector};
//!
//! /// Bending and twist with one stiffness C, N m²: `V = ½ C κ²`.
//! struct Round(f64);
//!
//! impl ConstitutiveLaw for Round {
//!     fn respond(&self, curvatures: &[Vector], _: Past<'_>, response: &mut Response<'_>) {
//!         let Self(c) = *self;
//!         response.each(curvatures, |_, kappa| Point {
//!             energy: 0.5 * c * kappa.norm_squared(),
//!             gradient: kappa * c,
//!             hessian: Matrix::identity() * c,
//!         });
//!     }
//! }
//!
//! fn round() -> ConstitutiveKind {
//!     ConstitutiveKind {
//!         name: "round".into(),
//!         doc: "twists as it bends".into(),
//!         parameters: vec![],
//!         build: Box::new(|spec, _| {
//!             let law = Round(spec.section.torsion_stiffness);
//!             // Stretch is that of the section.
//!             Ok(Box::new(ConstitutiveLaws { stretch: None, bend: Some(Box::new(law)) }))
//!         }),
//!     }
//! }
//!
//! wireloom_plugin::export! { rods: [round()] }
//! # fn main() {}
//! ```
//!
//! A panic in a function of the author is caught and becomes a fault of the plugin, with message and location; the run
//! ends and keeps its results so far. A library built with `panic = "abort"` terminates the program instead.
#![allow(unsafe_code, reason = "this crate is the safe side of a C boundary")]

mod constraint;
mod descriptors;
mod joint;
mod panics;
mod read;
mod rod;
mod table;

pub use wireloom_abi as abi;
pub use wireloom_core as core;

use abi::{Kinds, Text};
use std::sync::OnceLock;
use wireloom_core::registry::{ConstitutiveKind, ConstraintKind, JointKind};

/// Kinds of a plugin.
#[derive(Default)]
pub struct Plugin {
    /// Constraints.
    pub constraints: Vec<ConstraintKind>,
    /// Joint models.
    pub joints: Vec<JointKind>,
    /// Rods, by their constitutive laws.
    pub rods: Vec<ConstitutiveKind>,
}

/// Descriptors of a plugin's kinds, made on first use. Used by [`export!`].
#[doc(hidden)]
pub struct Descriptors(OnceLock<&'static Kinds>);

impl Descriptors {
    /// No descriptors yet.
    #[doc(hidden)]
    pub const fn empty() -> Self {
        Self(OnceLock::new())
    }

    /// The descriptors; null and a message if `plugin` panics.
    ///
    /// # Safety
    /// `message` is null, or a valid text buffer.
    #[doc(hidden)]
    pub unsafe fn kinds(&'static self, message: *mut Text, plugin: fn() -> Plugin) -> *const Kinds {
        panics::install_hook();
        let mut found = std::ptr::null();
        // SAFETY: as the caller promises.
        unsafe {
            panics::catch_panics(message, || {
                found = std::ptr::from_ref(*self.0.get_or_init(|| {
                    let Plugin { constraints, joints, rods } = plugin();
                    descriptors::kinds(constraints, joints, rods)
                }));
                Ok(())
            });
        }
        found
    }
}

/// Makes a library a plugin: `export! { constraints: [my_kind()] }`, or `joints: [...]`, or `rods: [...]`, or several
/// of them; once in a crate whose `crate-type` is `cdylib`.
///
/// Name, version and description are those of the crate. The brackets contain expressions of type
/// [`ConstraintKind`](core::registry::ConstraintKind), [`JointKind`](core::registry::JointKind) or
/// [`ConstitutiveKind`](core::registry::ConstitutiveKind).
#[macro_export]
macro_rules! export {
    ($($family:ident: [$($kind:expr),* $(,)?]),+ $(,)?) => {
        #[allow(unsafe_code, reason = "a plugin exports one symbol, and this is it")]
        const _: () = {
            unsafe extern "C" fn kinds(message: *mut $crate::abi::Text) -> *const $crate::abi::Kinds {
                static DESCRIPTORS: $crate::Descriptors = $crate::Descriptors::empty();
                #[allow(clippy::needless_update, reason = "all families may be named")]
                let plugin = || $crate::Plugin { $($family: vec![$($kind),*],)+ ..$crate::Plugin::default() };
                // SAFETY: the caller follows the ABI.
                unsafe { DESCRIPTORS.kinds(message, plugin) }
            }

            #[unsafe(no_mangle)]
            #[allow(non_upper_case_globals, reason = "the name that the ABI gives it")]
            pub static wireloom_plugin: $crate::abi::Entry = $crate::abi::Entry {
                magic: $crate::abi::MAGIC,
                size: size_of::<$crate::abi::Entry>() as u32,
                abi_major: $crate::abi::ABI_MAJOR,
                abi_minor: $crate::abi::ABI_MINOR,
                reserved: 0,
                name: concat!(env!("CARGO_PKG_NAME"), "\0").as_ptr().cast(),
                version: concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast(),
                doc: concat!(env!("CARGO_PKG_DESCRIPTION"), "\0").as_ptr().cast(),
                kinds: Some(kinds),
                get_extension: None,
            };
        };
    };
}

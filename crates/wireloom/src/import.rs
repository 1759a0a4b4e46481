//! Harness files of other programs, KBL and VEC, to scenarios. Results go back into KBL with [`kbl`](crate::kbl).
//!
//! ```
//! use wireloom::import::kbl::{Options, import};
//!
//! let refused = import("<not-kbl/>", &Options::default());
//! println!("{}", refused.err().expect("it is no KBL file"));
//! ```

pub use wireloom_import::{kbl, vec};

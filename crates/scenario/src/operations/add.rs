//! `add`: constraints that begin with a step.

use super::{Begins, StepOperation};
use crate::format::form::{Form, may};
use crate::format::keys::constraints::CONSTRAINT;

/// Constraints that begin with a step.
pub(crate) const ADD: StepOperation = StepOperation {
    key: may("add", Form::Tables(&CONSTRAINT), "constraints that begin with this step"),
    begins: |_| Begins::AtPlace,
    read: |_, _, _| None,
};

//! Kinds of the registry, as the format sees them.

use super::form::Family;
use wireloom_core::{Parameter, Registry, registry};

/// Name, documentation and parameters of a kind.
#[derive(Clone, Copy)]
pub(crate) struct KindInfo<'r> {
    pub name: &'r str,
    pub doc: &'r str,
    pub parameters: &'r [Parameter],
}

impl<'r, S, T: ?Sized> From<&'r registry::Kind<S, T>> for KindInfo<'r> {
    fn from(kind: &'r registry::Kind<S, T>) -> Self {
        Self { name: &kind.name, doc: &kind.doc, parameters: &kind.parameters }
    }
}

impl<'r> From<&'r registry::ConstraintKind> for KindInfo<'r> {
    fn from(kind: &'r registry::ConstraintKind) -> Self {
        Self { name: &kind.name, doc: &kind.doc, parameters: &kind.parameters }
    }
}

/// All kinds of a family, by name.
pub(crate) fn all(registry: &Registry, family: Family) -> Vec<KindInfo<'_>> {
    match family {
        Family::Rod => registry.rods().map(KindInfo::from).collect(),
        Family::Joint => registry.joints().map(KindInfo::from).collect(),
        Family::Constraint => registry.constraints().map(KindInfo::from).collect(),
        Family::Minimiser => registry.minimisers().map(KindInfo::from).collect(),
        Family::Shape => registry.shapes().map(KindInfo::from).collect(),
    }
}

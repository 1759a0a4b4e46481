//! The trace of the solver: a table on standard error (`-v`, `-vv`), and JSON lines in a file (`--trace`).
//!
//! The solver emits `tracing` spans (`step`: `name`, `index`; `increment`: `index`) and events (`wireloom::iteration`,
//! `wireloom::increment`, `wireloom::step`). Without these flags no subscriber is installed, and they cost nothing.

mod columns;
mod fields;
mod lines;

use crate::arguments::TraceArguments;
use crate::failure::Failure;
use crate::files::folder;
use crate::files::place::Pending;
use columns::Columns;
use fields::{Fields, Kept};
use lines::Lines;
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};
use tracing_subscriber::Registry;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::registry::LookupSpan;

/// Targets of the solver begin with this.
const TARGET: &str = "wireloom";

/// The trace of a run, from the moment that it is ready to begin.
#[derive(Default)]
pub struct Trace {
    file: Option<(PathBuf, Pending)>,
    lines: Option<Arc<Mutex<Lines>>>,
}

impl Trace {
    /// Installs what the flags ask for, for the rest of the process.
    ///
    /// # Errors
    /// Where the file cannot be made.
    pub fn begin(arguments: &TraceArguments) -> Result<Self, Failure> {
        let mut trace = Self::default();
        if let Some(path) = &arguments.file {
            let (pending, file) = folder::begin(path)?;
            trace.lines = Some(Arc::new(Mutex::new(Lines::new(file))));
            trace.file = Some((path.clone(), pending));
        }
        let columns = (arguments.verbose > 0).then(|| Mutex::new(Columns::new(arguments.verbose > 1)));
        if trace.lines.is_some() || columns.is_some() {
            let layer = Tracer { columns, lines: trace.lines.clone() };
            // Nothing else installs one in this program.
            let _ = tracing::subscriber::set_global_default(Registry::default().with(layer));
        }
        Ok(trace)
    }

    /// Gives the file its name, once; all spans have ended.
    ///
    /// # Errors
    /// Where it could not be written.
    pub fn finish(&mut self) -> Result<(), Failure> {
        let (Some((path, pending)), Some(lines)) = (self.file.take(), &self.lines) else { return Ok(()) };
        let written = locked(lines).finish();
        written.and_then(|file| pending.finish(file)).map(|_| ()).map_err(Failure::io("write", &path))
    }
}

/// The subscriber's only layer.
struct Tracer {
    columns: Option<Mutex<Columns>>,
    lines: Option<Arc<Mutex<Lines>>>,
}

/// Nothing panics while it holds one of these.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for Tracer {
    fn enabled(&self, metadata: &Metadata<'_>, _: Context<'_, S>) -> bool {
        metadata.target().starts_with(TARGET)
    }

    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let mut fields = Fields::default();
        attributes.record(&mut fields);
        if let Some(lines) = &self.lines {
            let outer: Vec<Kept> = span.scope().skip(1).filter_map(|span| span.extensions().get().cloned()).collect();
            locked(lines).span("new", span.name(), &fields, &outer);
        }
        if let Some(columns) = &self.columns {
            locked(columns).span(span.name(), &fields);
        }
        span.extensions_mut().insert(Kept { name: span.name(), fields });
    }

    fn on_record(&self, id: &Id, values: &Record<'_>, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        if let Some(kept) = span.extensions_mut().get_mut::<Kept>() {
            values.record(&mut kept.fields);
        }
    }

    fn on_event(&self, event: &Event<'_>, context: Context<'_, S>) {
        let mut fields = Fields::default();
        event.record(&mut fields);
        let target = event.metadata().target();
        if let Some(lines) = &self.lines {
            let scope = context.event_scope(event).into_iter().flatten();
            let outer: Vec<Kept> = scope.filter_map(|span| span.extensions().get().cloned()).collect();
            locked(lines).event(target, &fields, &outer);
        }
        if let Some(columns) = &self.columns {
            // If standard error is closed, nothing is lost.
            let _ = locked(columns).event(target, &fields, &mut io::stderr());
        }
    }

    fn on_close(&self, id: Id, context: Context<'_, S>) {
        let (Some(lines), Some(span)) = (&self.lines, context.span(&id)) else { return };
        let outer: Vec<Kept> = span.scope().skip(1).filter_map(|span| span.extensions().get().cloned()).collect();
        if let Some(kept) = span.extensions().get::<Kept>() {
            locked(lines).span("close", kept.name, &kept.fields, &outer);
        }
    }
}

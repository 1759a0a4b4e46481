//! Standard output that may be closed early.

use std::io::{self, BufWriter, ErrorKind, StdoutLock, Write};

/// Standard output; where the reader has closed it (`wireloom schema | head`), the rest is dropped silently, since
/// results are in files.
pub struct Output(BufWriter<StdoutLock<'static>>);

impl Output {
    /// Locks standard output for the rest of the program.
    pub fn stdout() -> Self {
        Self(BufWriter::new(io::stdout().lock()))
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        forgive(self.0.write(bytes), bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        forgive(self.0.flush(), ())
    }
}

fn forgive<T>(result: io::Result<T>, done: T) -> io::Result<T> {
    match result {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(done),
        other => other,
    }
}

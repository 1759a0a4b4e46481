//! Tables as Parquet files.
//!
//! | column | encoding |
//! | --- | --- |
//! | whole numbers | differences (delta binary packed) |
//! | numbers | byte stream split: the first bytes of all numbers, then the second ones; they compress well |
//! | texts | dictionary |
//! | yes or no | bits |

use super::{Column, Kind, Table};
use bytes::Bytes;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::{KeyValue, ParquetMetaData, ParquetMetaDataReader};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type};
use std::io::{self, Write};
use std::sync::Arc;

/// Writer of a table as Parquet, some rows at a time.
pub struct Writer<W: Write + Send> {
    file: SerializedFileWriter<W>,
}

impl<W: Write + Send> Writer<W> {
    /// Begins a file with the columns and the metadata of a table, without its rows.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn begin(table: &Table, out: W) -> io::Result<Self> {
        let attempt = |out| -> Result<Self, ParquetError> {
            let fields = table.columns.iter().map(|(name, column)| Ok(Arc::new(column.field(name)?)));
            let fields = fields.collect::<Result<Vec<_>, ParquetError>>()?;
            let schema = Arc::new(Type::group_type_builder("points").with_fields(fields).build()?);
            let notes = table.notes.iter().map(|(key, text)| KeyValue::new(key.clone(), text.clone())).collect();
            let mut properties = WriterProperties::builder()
                .set_compression(Compression::SNAPPY)
                .set_statistics_enabled(EnabledStatistics::Chunk)
                .set_key_value_metadata(Some(notes));
            for (name, column) in &table.columns {
                // A name with dots is one name.
                let path = ColumnPath::new(vec![name.clone()]);
                let encoding = match column.kind() {
                    Kind::Counts => Encoding::DELTA_BINARY_PACKED,
                    Kind::Numbers => Encoding::BYTE_STREAM_SPLIT,
                    Kind::Words | Kind::Flags => continue,
                };
                properties =
                    properties.set_column_dictionary_enabled(path.clone(), false).set_column_encoding(path, encoding);
            }
            Ok(Self { file: SerializedFileWriter::new(out, schema, Arc::new(properties.build()))? })
        };
        attempt(out).map_err(io::Error::other)
    }

    /// Adds the rows of a table with the same columns.
    ///
    /// # Errors
    /// Those of the output.
    pub fn append(&mut self, table: &Table) -> io::Result<()> {
        let attempt = |file: &mut SerializedFileWriter<W>| -> Result<(), ParquetError> {
            let mut group = file.next_row_group()?;
            for (_, column) in &table.columns {
                match column {
                    Column::Counts(entries) => put::<Int64Type, _>(&mut group, entries, |x| *x)?,
                    Column::Numbers(entries) => put::<DoubleType, _>(&mut group, entries, |x| *x)?,
                    Column::Flags(entries) => put::<BoolType, _>(&mut group, entries, |x| *x)?,
                    Column::Words(entries) => {
                        put::<ByteArrayType, _>(&mut group, entries, |word| ByteArray::from(word.as_str()))?;
                    }
                }
            }
            group.close()?;
            Ok(())
        };
        attempt(&mut self.file).map_err(io::Error::other)
    }

    /// Completes the file.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(self) -> io::Result<()> {
        self.file.close().map(|_| ()).map_err(io::Error::other)
    }
}

/// Fields of a part of a table that is written at once: 32 MB.
const FIELDS: usize = 1 << 21;

/// Writer of a table that grows chain by chain. However the chains come, equal rows give equal bytes.
pub struct Grouped<W: Write + Send> {
    writer: Writer<W>,
    columns: usize,
    pending: Table,
}

impl<W: Write + Send> Grouped<W> {
    /// Begins a file with the columns and the metadata of a table, without its rows.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn begin(table: &Table, out: W) -> io::Result<Self> {
        let writer = Writer::begin(table, out)?;
        Ok(Self { writer, columns: table.columns.len().max(1), pending: Table::default() })
    }

    /// Adds the rows of a chain.
    ///
    /// # Errors
    /// Those of the output.
    pub fn add(&mut self, chain: Table) -> io::Result<()> {
        self.pending.append(chain);
        if self.pending.rows() * self.columns >= FIELDS { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        let pending = std::mem::take(&mut self.pending);
        if pending.rows() > 0 { self.writer.append(&pending) } else { Ok(()) }
    }

    /// Completes the file.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(mut self) -> io::Result<()> {
        self.flush()?;
        self.writer.finish()
    }
}

fn put<T: DataType, E>(
    group: &mut SerializedRowGroupWriter<'_, impl Write + Send>,
    entries: &[Option<E>],
    stored: impl Fn(&E) -> T::T,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Ok(()) };
    let present: Vec<i16> = entries.iter().map(|entry| i16::from(entry.is_some())).collect();
    let values: Vec<T::T> = entries.iter().flatten().map(stored).collect();
    column.typed::<T>().write_batch(&values, Some(&present), None)?;
    column.close()
}

/// Reads a table that [`Writer`] has written.
///
/// # Errors
/// `InvalidData`, with the reason, where it is none.
pub fn read(bytes: Vec<u8>) -> io::Result<Table> {
    let attempt = || -> Result<Table, ParquetError> {
        let file = SerializedFileReader::new(Bytes::from(bytes))?;
        let metadata = file.metadata();
        let notes = notes(metadata);
        let mut columns: Vec<(String, Column)> = Vec::new();
        for g in 0..metadata.num_row_groups() {
            let group = file.get_row_group(g)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            for c in 0..group.num_columns() {
                let name = group.metadata().column(c).column_descr().name().to_owned();
                let read = entries(group.get_column_reader(c)?, rows)?;
                match columns.get_mut(c) {
                    None => columns.push((name, read)),
                    Some((_, column)) => {
                        if !column.append(read) {
                            return Err(ParquetError::General("a column changes its type".to_owned()));
                        }
                    }
                }
            }
        }
        Ok(Table { columns, notes })
    };
    attempt().map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

fn notes(metadata: &ParquetMetaData) -> Vec<(String, String)> {
    let notes = metadata.file_metadata().key_value_metadata().into_iter().flatten();
    notes.map(|note| (note.key.clone(), note.value.clone().unwrap_or_default())).collect()
}

/// What stands at the end of a file: its columns and metadata, without rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// The table without its rows.
    pub table: Table,
    /// Number of its rows.
    pub rows: usize,
}

/// The end of a file that [`Writer`] has written, or a part of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Tail {
    /// All that was looked for.
    Head(Head),
    /// It needs this number of bytes from the end of the file.
    Short(u64),
}

/// Reads columns and metadata of a table from the last bytes of its file.
///
/// # Errors
/// `InvalidData`, with the reason, where it is none.
pub fn head(tail: Vec<u8>, size: u64) -> io::Result<Tail> {
    let attempt = || -> Result<Tail, ParquetError> {
        let mut reader = ParquetMetaDataReader::new();
        match reader.try_parse_sized(&Bytes::from(tail), size) {
            Err(ParquetError::NeedMoreData(bytes)) => return Ok(Tail::Short(bytes as u64)),
            parsed => parsed?,
        }
        let metadata = reader.finish()?;
        let columns = metadata.file_metadata().schema_descr().columns().iter().map(|column| {
            let kind = match column.physical_type() {
                Physical::INT64 => Kind::Counts,
                Physical::DOUBLE => Kind::Numbers,
                Physical::BYTE_ARRAY => Kind::Words,
                Physical::BOOLEAN => Kind::Flags,
                _ => return Err(foreign()),
            };
            Ok((column.name().to_owned(), Column::nulls(kind, 0)))
        });
        let table = Table { columns: columns.collect::<Result<_, _>>()?, notes: notes(&metadata) };
        let rows = usize::try_from(metadata.file_metadata().num_rows()).unwrap_or(0);
        Ok(Tail::Head(Head { table, rows }))
    };
    attempt().map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

fn foreign() -> ParquetError {
    ParquetError::General("a column is neither number, text nor flag".to_owned())
}

fn entries(reader: ColumnReader, rows: usize) -> Result<Column, ParquetError> {
    macro_rules! read {
        ($reader:expr, $stored:expr) => {{
            let mut reader = $reader;
            let (mut values, mut present) = (Vec::new(), Vec::new());
            reader.read_records(rows, Some(&mut present), None, &mut values)?;
            let mut values = values.into_iter().map($stored);
            present.into_iter().map(|level| if level > 0 { values.next() } else { None }).collect()
        }};
    }
    let text = |word: ByteArray| String::from_utf8_lossy(word.data()).into_owned();
    Ok(match reader {
        ColumnReader::Int64ColumnReader(reader) => Column::Counts(read!(reader, |x| x)),
        ColumnReader::DoubleColumnReader(reader) => Column::Numbers(read!(reader, |x| x)),
        ColumnReader::BoolColumnReader(reader) => Column::Flags(read!(reader, |x| x)),
        ColumnReader::ByteArrayColumnReader(reader) => Column::Words(read!(reader, text)),
        _ => return Err(foreign()),
    })
}

impl Column {
    fn field(&self, name: &str) -> Result<Type, ParquetError> {
        let (physical, logical) = match self {
            Column::Counts(_) => (Physical::INT64, None),
            Column::Numbers(_) => (Physical::DOUBLE, None),
            Column::Words(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Column::Flags(_) => (Physical::BOOLEAN, None),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
        field.with_logical_type(logical).build()
    }
}

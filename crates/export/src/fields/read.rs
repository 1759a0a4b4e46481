//! Reader of `fields.arrow`.

use super::{ALWAYS, BranchFields, COLUMNS, FILE, NAMES, failed, schema};
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, RecordBatch};
use arrow_buffer::Buffer;
use arrow_ipc::reader::{FileDecoder, read_footer_length};
use arrow_ipc::{Block, MetadataVersion, root_as_footer};
use sha2::{Digest, Sha256};
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;
use wireloom_core::Vector;

/// Bytes at the end of a file: the length of the footer, and the mark of the format.
const TRAILER: u64 = 10;
/// Largest footer that is read, bytes: millions of equilibria.
const LARGEST_FOOTER: u64 = 1 << 28;

/// Reads equilibria one by one. Nothing of the file is decoded before its checksum is found right.
pub struct Reader<R> {
    input: R,
    blocks: Vec<Block>,
    decoder: FileDecoder,
    /// Whether it has each of the columns behind the first [`ALWAYS`].
    optional: [bool; COLUMNS.len() - ALWAYS],
}

impl<R: Read + Seek> Reader<R> {
    /// Reads where the equilibria lie in the file.
    ///
    /// # Errors
    /// Those of `input`; `InvalidData` where it is no such file.
    pub fn open(mut input: R) -> io::Result<Self> {
        let length = input.seek(SeekFrom::End(0))?;
        let end = length.checked_sub(TRAILER).ok_or_else(|| invalid("it is too short"))?;
        let mut trailer = [0; TRAILER as usize];
        input.seek(SeekFrom::Start(end))?;
        input.read_exact(&mut trailer)?;
        let footer = read_footer_length(trailer).map_err(|_| invalid("its end is missing"))? as u64;
        let start = end.checked_sub(footer).filter(|_| footer <= LARGEST_FOOTER);
        let start = start.ok_or_else(|| invalid("its end is damaged"))?;
        let bytes = part(&mut input, start..end)?;
        let footer = root_as_footer(&bytes).map_err(|_| invalid("its end is damaged"))?;
        let fields = footer.schema().and_then(|schema| schema.fields());
        let names: Vec<&str> = fields.iter().flatten().filter_map(|field| field.name()).collect();
        let optional = [ALWAYS, ALWAYS + 1].map(|k| names.contains(&COLUMNS[k].0));
        let own = schema("", optional);
        if !own.fields().iter().map(|field| field.name().as_str()).eq(names.iter().copied()) {
            return Err(invalid("its columns are not those that are known to this version"));
        }
        let blocks: Vec<Block> =
            footer.recordBatches().map(|blocks| blocks.iter().copied().collect()).unwrap_or_default();
        let mut from = 0;
        for block in &blocks {
            let place = place(block).filter(|place| from <= place.start && place.end <= start);
            from = place.ok_or_else(|| invalid("its end is damaged"))?.end;
        }
        let numbers = (NAMES.len()..names.len()).collect();
        let decoder = FileDecoder::new(Arc::new(own), MetadataVersion::V5).with_projection(numbers);
        Ok(Self { input, blocks, decoder, optional })
    }

    /// Number of equilibria.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// The fields of the branches of equilibrium `k`; `nodes`: the number of nodes of each; `hash`: the checksum.
    ///
    /// # Errors
    /// Those of the input; `InvalidData` where it is not what was written.
    pub fn read(&mut self, k: usize, nodes: &[usize], hash: &str) -> io::Result<Vec<BranchFields>> {
        let other = || invalid(&format!("equilibrium {} is not the one of result.json, or it is damaged", k + 1));
        let block = self.blocks.get(k).ok_or_else(other)?;
        let place = place(block).ok_or_else(other)?;
        let before = k.checked_sub(1).and_then(|k| self.blocks.get(k)).and_then(self::place);
        let from = before.map_or(0, |before| before.end);
        let bytes = part(&mut self.input, from..place.end)?;
        if format!("{:x}", Sha256::digest(&bytes)) != hash {
            return Err(other());
        }
        let own = Buffer::from_vec(bytes).slice((place.start - from) as usize);
        let batch = self.decoder.read_record_batch(block, &own).map_err(failed)?.ok_or_else(other)?;
        let rows = nodes.iter().try_fold(0usize, |sum, n| sum.checked_add(*n));
        if rows != Some(batch.num_rows()) {
            return Err(other());
        }
        let mut from = 0;
        let mut branch = |n: &usize| {
            let rows = from..from + n;
            from += n;
            of_rows(&batch, rows, self.optional)
        };
        Ok(nodes.iter().map(&mut branch).collect())
    }
}

/// Bytes of the input.
fn part(input: &mut (impl Read + Seek), range: Range<u64>) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; (range.end - range.start) as usize];
    input.seek(SeekFrom::Start(range.start))?;
    input.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Place of a block in the file; none for one that cannot be.
fn place(block: &Block) -> Option<Range<u64>> {
    let start = u64::try_from(block.offset()).ok()?;
    let length = u64::try_from(block.metaDataLength()).ok()?.checked_add(u64::try_from(block.bodyLength()).ok()?)?;
    Some(start..start.checked_add(length)?)
}

/// The fields of a branch, whose columns are those of [`COLUMNS`].
fn of_rows(batch: &RecordBatch, rows: Range<usize>, [set, strain]: [bool; COLUMNS.len() - ALWAYS]) -> BranchFields {
    let all = |column: usize| batch.column(column).as_primitive::<Float64Type>().values();
    let numbers = |column: usize| all(column)[rows.clone()].to_vec();
    let vectors = |column: usize| {
        let list = batch.column(column).as_fixed_size_list();
        let numbers = list.values().as_primitive::<Float64Type>().values();
        let own = &numbers[3 * (list.offset() + rows.start)..3 * (list.offset() + rows.end)];
        own.as_chunks::<3>().0.iter().copied().map(Vector::from).collect()
    };
    BranchFields {
        s: numbers(0),
        position: vectors(1),
        d3: vectors(2),
        d1: vectors(3),
        force: vectors(4),
        moment: vectors(5),
        bend_radius: numbers(6),
        set: set.then(|| vectors(ALWAYS)),
        strain: Some(ALWAYS + usize::from(set))
            .filter(|column| strain && rows.clone().all(|row| batch.column(*column).is_valid(row)))
            .map(numbers),
    }
}

fn invalid(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("{FILE}: {what}"))
}

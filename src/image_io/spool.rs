//! The spool, which holds the bytes of a file until the file is complete.

use super::complete_file::nameless_file;
use super::part_file::RowSource;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Cursor, Read, Seek, Write};
use std::path::PathBuf;

/// Bytes in memory or, if there are more than [`IN_MEMORY`], in a temporary file without a name, which the system
/// removes however the program ends.
#[derive(Debug)]
pub(super) struct Spool {
    memory: Vec<u8>,
    file: Option<BufWriter<File>>,
    /// The folder of the temporary file, which is on the disk of the finished file.
    folder: PathBuf,
    /// The lengths of a header and of each row after it, if the rows are to be written in reverse.
    reversed: Option<(usize, usize)>,
}

/// Upper bound on the bytes in memory.
const IN_MEMORY: usize = 8 << 20;

/// The size of a file buffer, in bytes.
const BUFFER_SIZE: usize = 1 << 18;

impl Spool {
    /// An empty spool that is expected to hold this number of bytes.
    pub fn new(folder: PathBuf, expected: usize) -> Self {
        Self { memory: Vec::with_capacity(expected.min(IN_MEMORY)), file: None, folder, reversed: None }
    }

    /// Says that a header of this many bytes precedes rows of this many bytes each, of which the last is to be
    /// written first.
    pub fn reverse_rows(&mut self, header: usize, row: usize) {
        self.reversed = Some((header, row));
    }

    /// Replaces bytes that are there, from this place on.
    pub fn overwrite(&mut self, at: usize, bytes: &[u8]) -> io::Result<()> {
        let Some(file) = &mut self.file else {
            self.memory[at..at + bytes.len()].copy_from_slice(bytes);
            return Ok(());
        };
        file.seek(io::SeekFrom::Start(at as u64))?;
        file.write_all(bytes)?;
        file.seek(io::SeekFrom::End(0)).map(drop)
    }

    /// The bytes, to be read from the first one on.
    pub fn into_source(self) -> io::Result<Box<dyn RowSource>> {
        let Some(file) = self.file else { return Ok(Box::new(Cursor::new(self.memory))) };
        let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        Ok(Box::new(BufReader::with_capacity(BUFFER_SIZE, file)))
    }

    /// Writes everything to `target`.
    pub fn copy_to(self, mut target: impl Write) -> io::Result<()> {
        let Some(file) = self.file else {
            let (start, rows) =
                self.memory.split_at(self.reversed.map_or(self.memory.len(), |(header, _)| header));
            target.write_all(start)?;
            let row = self.reversed.map_or(1, |(_, row)| row);
            rows.rchunks_exact(row).try_for_each(|row| target.write_all(row))?;
            return target.flush();
        };
        let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        let mut target = BufWriter::with_capacity(BUFFER_SIZE, target);
        match self.reversed {
            Some((header, row)) => copy_rows_reversed(&mut file, header as u64, row, &mut target)?,
            None => drop(io::copy(&mut file, &mut target)?),
        }
        target.flush()
    }
}

/// Copies the header, then the rows from the last to the first, as many at a time as the buffer holds.
fn copy_rows_reversed(file: &mut File, header: u64, row: usize, target: &mut impl Write) -> io::Result<()> {
    io::copy(&mut Read::by_ref(file).take(header), target)?;
    let mut end = file.seek(io::SeekFrom::End(0))?;
    let mut block = vec![0; row * (BUFFER_SIZE / row).max(1)];
    while end > header {
        let length = (end - header).min(block.len() as u64);
        end = file.seek(io::SeekFrom::Start(end - length))?;
        let rows = &mut block[..length as usize];
        file.read_exact(rows)?;
        rows.rchunks_exact(row).try_for_each(|row| target.write_all(row))?;
    }
    Ok(())
}

impl Write for Spool {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(file) = &mut self.file {
            return file.write(bytes);
        }
        if self.memory.len() + bytes.len() > IN_MEMORY {
            let mut file = BufWriter::with_capacity(BUFFER_SIZE, nameless_file(&self.folder)?);
            file.write_all(&std::mem::take(&mut self.memory))?;
            return self.file.insert(file).write(bytes);
        }
        self.memory.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn bytes_come_back_from_memory_and_from_a_file() {
        for pieces in [0, 1, 700, 1100] {
            let piece: Vec<u8> = (0..10_000).map(|i| (i % 251) as u8).collect();
            let folder = tempfile::tempdir().unwrap();
            let mut spool = Spool::new(folder.path().to_owned(), 0);
            (0..pieces).for_each(|_| spool.write_all(&[0; 10_000]).unwrap());
            (0..pieces).for_each(|index| spool.overwrite(index * piece.len(), &piece).unwrap());
            spool.write_all(b"end").unwrap();
            assert_eq!(spool.file.is_some(), pieces * piece.len() > IN_MEMORY);
            // On Windows it has a name until it is closed.
            let names = usize::from(cfg!(windows) && spool.file.is_some());
            assert_eq!(folder.path().read_dir().unwrap().count(), names, "the file has no name");
            let mut target = tempfile::tempfile().unwrap();
            spool.copy_to(&target).unwrap();
            let mut found = Vec::new();
            target.rewind().unwrap();
            target.read_to_end(&mut found).unwrap();
            assert!(found == [piece.repeat(pieces), b"end".to_vec()].concat());
        }
    }

    #[test]
    fn rows_come_back_in_reverse_from_memory_and_from_a_file() {
        // The rows of the last two are longer than the buffer, or fill it several times with a rest.
        for (row, rows) in [(3, 0), (3, 1), (3, 5), (12, 800_000), (BUFFER_SIZE + 1, 33), (1 << 13, 1030)] {
            let numbers: Vec<u32> = (0..rows as u32).collect();
            let fill = |number: u32| (0..row as u32).map(move |i| (number.wrapping_mul(7) ^ i) as u8);
            let folder = tempfile::tempdir().unwrap();
            let mut spool = Spool::new(folder.path().to_owned(), 0);
            spool.reverse_rows(5, row);
            spool.write_all(b"start").unwrap();
            numbers.iter().for_each(|&n| spool.write_all(&fill(n).collect::<Vec<_>>()).unwrap());
            assert_eq!(spool.file.is_some(), row * rows > IN_MEMORY);
            let mut found = Vec::new();
            spool.copy_to(&mut found).unwrap();
            let expected: Vec<u8> =
                b"start".iter().copied().chain(numbers.into_iter().rev().flat_map(fill)).collect();
            assert!(found == expected, "{row} x {rows}");
        }
    }
}

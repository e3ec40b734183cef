//! Bytes that wait for their file to be complete.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::PathBuf;

/// Bytes that wait in memory, and beyond [`IN_MEMORY`] in a file without a name, which the system removes however the
/// program ends.
pub(super) struct Spool {
    memory: Vec<u8>,
    file: Option<BufWriter<File>>,
    /// Where the file without a name stands: on the disk that will hold the finished one.
    folder: PathBuf,
}

const IN_MEMORY: usize = 8 << 20;

/// Bytes that are handed to the system in one piece.
const PIECE: usize = 1 << 18;

impl Spool {
    /// A spool that expects so many bytes.
    pub fn new(folder: PathBuf, expected: usize) -> Self {
        Self { memory: Vec::with_capacity(expected.min(IN_MEMORY)), file: None, folder }
    }

    /// Writes everything to `target`.
    pub fn copy_to(self, mut target: &File) -> io::Result<()> {
        let Some(file) = self.file else { return target.write_all(&self.memory) };
        let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        let mut target = BufWriter::with_capacity(PIECE, target);
        io::copy(&mut file, &mut target)?;
        target.flush()
    }
}

impl Write for Spool {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(file) = &mut self.file {
            return file.write(bytes);
        }
        if self.memory.len() + bytes.len() > IN_MEMORY {
            let mut file = BufWriter::with_capacity(PIECE, tempfile::tempfile_in(&self.folder)?);
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
            (0..pieces).for_each(|_| spool.write_all(&piece).unwrap());
            assert_eq!(spool.file.is_some(), pieces * piece.len() > IN_MEMORY);
            assert_eq!(folder.path().read_dir().unwrap().count(), 0, "the file has no name");
            let mut target = tempfile::tempfile().unwrap();
            spool.copy_to(&target).unwrap();
            let mut found = Vec::new();
            target.rewind().unwrap();
            target.read_to_end(&mut found).unwrap();
            assert!(found == piece.repeat(pieces));
        }
    }
}

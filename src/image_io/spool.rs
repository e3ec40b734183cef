//! The spool, which holds the bytes of a file until the file is complete.

use crate::memory::{make_room, with_room};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::PathBuf;

/// Bytes in memory or, if there are more than [`IN_MEMORY`] or than there is memory for, in a temporary file
/// without a name, which the system removes however the program ends.
pub(super) struct Spool {
    memory: Vec<u8>,
    file: Option<BufWriter<File>>,
    /// The folder of the temporary file, which is on the disk of the finished file.
    folder: PathBuf,
}

/// Upper bound on the bytes in memory.
const IN_MEMORY: usize = 8 << 20;

/// The size of a file buffer, in bytes.
const BUFFER_SIZE: usize = 1 << 18;

impl Spool {
    /// An empty spool that is expected to hold this number of bytes.
    pub fn new(folder: PathBuf, expected: usize) -> Self {
        let memory = with_room(expected.min(IN_MEMORY)).unwrap_or_default();
        Self { memory, file: None, folder }
    }

    /// Writes everything to `target`.
    pub fn copy_to(self, mut target: &File) -> io::Result<()> {
        let Some(file) = self.file else { return target.write_all(&self.memory) };
        let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        let mut target = BufWriter::with_capacity(BUFFER_SIZE, target);
        io::copy(&mut file, &mut target)?;
        target.flush()
    }
}

impl Write for Spool {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(file) = &mut self.file {
            return file.write(bytes);
        }
        let fits = self.memory.len() + bytes.len() <= IN_MEMORY;
        if !fits || make_room(&mut self.memory, bytes.len()).is_err() {
            let mut file = BufWriter::with_capacity(BUFFER_SIZE, tempfile::tempfile_in(&self.folder)?);
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

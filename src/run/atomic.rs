// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that appear whole or not at all: written beside their place, synced, then renamed into it.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// What could not be done to which file, and why. The message says all three, so there is no source to print.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot {doing}: {cause}", path.display())]
pub struct FileError {
    /// The file that was asked for, never the temporary one.
    pub path: PathBuf,
    /// What failed, as it reads after "cannot".
    pub doing: &'static str,
    /// What the operating system or the format's library said.
    pub cause: io::Error,
}

/// A result whose error names the file.
pub type Result<T> = std::result::Result<T, FileError>;

/// For `map_err`: says which file and which operation an [`io::Error`] belongs to.
pub fn failed(path: &Path, doing: &'static str) -> impl Fn(io::Error) -> FileError {
    let path = path.to_owned();
    move |cause| FileError { path: path.clone(), doing, cause }
}

/// A file under a temporary name in the directory of `path`. [`commit`](Self::commit) puts it in its place;
/// dropped before that, it is removed and whatever was there stays as it was.
#[derive(Debug)]
pub struct Pending {
    path: PathBuf,
    temporary: PathBuf,
    file: File,
    committed: bool,
}

impl Pending {
    /// Creates the temporary file, empty.
    pub fn new(path: &Path) -> Result<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let error = failed(path, "create a file in its directory");
        let name = path.file_name().ok_or_else(|| error(io::ErrorKind::InvalidFilename.into()))?;
        loop {
            let mut unique = std::ffi::OsString::from(".");
            unique.push(name);
            unique.push(format!(".{}-{}.tmp", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed)));
            let temporary = path.with_file_name(unique);
            match OpenOptions::new().read(true).write(true).create_new(true).open(&temporary) {
                Ok(file) => return Ok(Self { path: path.to_owned(), temporary, file, committed: false }),
                // Left by a killed process that had our id.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                Err(e) => return Err(error(e)),
            }
        }
    }

    /// The file, open for reading and writing.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Where the file is until it is committed: for a program that writes it by name.
    pub fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Brings the contents to the disk and the file to its place, over one that is there.
    pub fn commit(mut self) -> Result<()> {
        self.file.sync_all().map_err(failed(&self.path, "bring it to the disk"))?;
        fs::rename(&self.temporary, &self.path).map_err(failed(&self.path, "rename the new file to it"))?;
        self.committed = true;
        // The file is in place now. Some file systems cannot sync a directory, which is no reason to say
        // otherwise.
        #[cfg(unix)]
        if let Some(directory) = self.path.parent() {
            let here = if directory.as_os_str().is_empty() { Path::new(".") } else { directory };
            let _ = File::open(here).and_then(|d| d.sync_all());
        }
        Ok(())
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        if !self.committed {
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

/// Replaces the file at `path` by what `contents` writes, buffered. On an error, of `contents` too, nothing
/// is left behind and the old file is intact.
pub fn write_atomic(path: &Path, contents: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let pending = Pending::new(path)?;
    let mut buffered = BufWriter::new(pending.file());
    contents(&mut buffered).and_then(|()| buffered.flush()).map_err(failed(path, "write it"))?;
    drop(buffered);
    pending.commit()
}

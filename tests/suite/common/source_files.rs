//! The files of a source tree.

use std::fs::read_dir;
use std::path::PathBuf;

/// All files of a folder and its folders.
pub fn source_files(folder: PathBuf) -> Vec<PathBuf> {
    let (folders, files): (Vec<_>, Vec<_>) =
        read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).partition(|path| path.is_dir());
    files.into_iter().chain(folders.into_iter().flat_map(source_files)).collect()
}

//! Text files, read whole but not without bounds.

use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::Path;

/// The text of a file of at most `most` bytes.
///
/// # Errors
/// Why there is none.
pub fn read(path: &Path, most: u64) -> Result<String, String> {
    let mut text = String::new();
    let file = File::open(path).map_err(|e| format!("cannot be read: {e}"))?;
    file.take(most + 1).read_to_string(&mut text).map_err(|e| match e.kind() {
        ErrorKind::InvalidData => "cannot be read: it is no text in UTF-8".to_string(),
        _ => format!("cannot be read: {e}"),
    })?;
    if text.len() as u64 > most {
        return Err(format!("is larger than {} MB: more is not taken", most >> 20));
    }
    Ok(text)
}

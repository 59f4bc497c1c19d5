//! Files that are checked before they are believed: checkpoints and shards.
//!
//! ```text
//! kind (8 bytes) | format (u32) | key (32) | length of the content (u64) | content | SHA-256 of all before (32)
//! ```
//!
//! Numbers are little-endian. The content is what `postcard` makes of it; the key tells what it belongs to.

use std::fmt;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

/// What a file belongs to: a hash of all that its content depends on.
pub type Key = [u8; 32];

/// What is in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Work that was broken off.
    Checkpoint,
    /// A finished part of a plan.
    Shard,
}

impl Kind {
    fn magic(self) -> &'static [u8; 8] {
        match self {
            Self::Checkpoint => b"GONIOCKP",
            Self::Shard => b"GONIOSHD",
        }
    }
}

/// Changes with everything that is in [`super::State`].
const FORMAT: u32 = 1;
const KEY_AT: usize = 12;
const LENGTH_AT: usize = KEY_AT + 32;
const CONTENT_AT: usize = LENGTH_AT + 8;
const SUM: usize = 32;

/// Why the content of a file is not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// It is no such file.
    Other,
    /// It was written by another version of the program.
    Version,
    /// Its end is missing.
    Truncated,
    /// Its bytes are not those that were written.
    Damaged,
    /// It belongs to something else.
    Foreign,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Other => "is no file of this kind",
            Self::Version => "was written by another version of the program",
            Self::Truncated => "is cut off: its end is missing",
            Self::Damaged => "is damaged: its bytes are not those that were written",
            Self::Foreign => "belongs to something else: sample, options, seed or program were not the same",
        })
    }
}

/// Bytes of a file.
pub fn seal(kind: Kind, key: &Key, content: &impl Serialize) -> Vec<u8> {
    let content = postcard::to_stdvec(content).expect("plain data");
    let mut bytes = Vec::with_capacity(CONTENT_AT + content.len() + SUM);
    bytes.extend_from_slice(kind.magic());
    bytes.extend_from_slice(&FORMAT.to_le_bytes());
    bytes.extend_from_slice(key);
    bytes.extend_from_slice(&(content.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&content);
    let sum = Sha256::digest(&bytes);
    bytes.extend_from_slice(&sum);
    bytes
}

/// The content of a file that belongs to `key`.
///
/// # Errors
/// Why it is not to be believed.
pub fn unseal<T: DeserializeOwned>(kind: Kind, key: &Key, bytes: &[u8]) -> Result<T, Broken> {
    let magic = kind.magic();
    if !bytes.starts_with(&magic[..magic.len().min(bytes.len())]) || bytes.is_empty() {
        return Err(Broken::Other);
    }
    let (Some(format), Some(length)) = (bytes.get(8..KEY_AT), bytes.get(LENGTH_AT..CONTENT_AT)) else {
        return Err(Broken::Truncated);
    };
    if format != FORMAT.to_le_bytes() {
        return Err(Broken::Version);
    }
    let length = length.iter().rev().fold(0u64, |sum, &byte| sum << 8 | u64::from(byte));
    match (bytes.len() as u64).cmp(&length.saturating_add((CONTENT_AT + SUM) as u64)) {
        std::cmp::Ordering::Less => return Err(Broken::Truncated),
        std::cmp::Ordering::Greater => return Err(Broken::Damaged),
        std::cmp::Ordering::Equal => {}
    }
    let (sealed, sum) = bytes.split_at(bytes.len() - SUM);
    if Sha256::digest(sealed)[..] != *sum {
        return Err(Broken::Damaged);
    }
    if sealed[KEY_AT..LENGTH_AT] != *key {
        return Err(Broken::Foreign);
    }
    postcard::from_bytes(&sealed[CONTENT_AT..]).map_err(|_| Broken::Damaged)
}

/// The hash of some texts; where one ends and the next begins matters.
pub fn key_of(texts: &[&str]) -> Key {
    let mut hash = Sha256::new();
    for text in texts {
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    hash.finalize().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_nothing_else() {
        let (key, content) = (key_of(&["a", "b"]), vec![1.5, f64::NAN, f64::INFINITY]);
        let bytes = seal(Kind::Shard, &key, &content);
        let read = |bytes: &[u8]| unseal::<Vec<f64>>(Kind::Shard, &key, bytes);
        assert_eq!(read(&bytes).unwrap()[0].to_bits(), content[0].to_bits());
        assert!(read(&bytes).unwrap()[1].is_nan());
        (1..bytes.len()).for_each(|n| assert_eq!(read(&bytes[..n]), Err(Broken::Truncated), "{n}"));
        for at in 0..bytes.len() {
            let mut tampered = bytes.clone();
            tampered[at] ^= 1;
            assert!(read(&tampered).is_err(), "{at}");
        }
        assert_eq!(read(b""), Err(Broken::Other));
        assert_eq!(read(b"anything"), Err(Broken::Other));
        assert_eq!(unseal::<Vec<f64>>(Kind::Checkpoint, &key, &bytes), Err(Broken::Other));
        assert_eq!(unseal::<Vec<f64>>(Kind::Shard, &key_of(&["ab", ""]), &bytes), Err(Broken::Foreign));
        let mut longer = bytes.clone();
        longer.push(0);
        assert_eq!(read(&longer), Err(Broken::Damaged));
    }
}

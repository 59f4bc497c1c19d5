//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Writes `bytes` to `path`: beside it first, then by renaming, so that what was there stays until the new file
/// is complete. What broken-off attempts have left beside it is removed.
///
/// # Errors
/// What the file system reports; then nothing has changed.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    sweep(path);
    let part = part_of(path)?;
    let written = File::create(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    let done = written.and_then(|()| fs::rename(&part, path)).map(|()| settle(path));
    if done.is_err() {
        let _ = fs::remove_file(&part);
    }
    done
}

/// Removes a file, if it is there, with what broken-off attempts to write it have left.
///
/// # Errors
/// What the file system reports.
pub fn remove(path: &Path) -> io::Result<()> {
    sweep(path);
    match fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

/// Finds out, before long work, whether [`write()`] will be possible.
///
/// # Errors
/// What the file system reports.
pub fn check(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
    }
    let part = part_of(path)?;
    File::create(&part)?;
    fs::remove_file(&part)
}

/// After a loss of power the new name is there, too. Not all systems can see to that.
fn settle(path: &Path) {
    if cfg!(unix) {
        let _ = File::open(directory(path)).and_then(|d| d.sync_all());
    }
}

fn directory(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The name beside `path` under which it is written; no other process has it.
fn part_of(path: &Path) -> io::Result<PathBuf> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "it names no file"))?;
    let mut part = name.to_os_string();
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    part.push(format!("{PART}{}-{}-{number}", host(), process::id()));
    Ok(path.with_file_name(part))
}

/// What stands between the name of a file and who writes it.
const PART: &str = ".part-";

fn host() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    name.chars().filter(char::is_ascii_alphanumeric).collect()
}

/// What nobody writes to for so long has been left.
const FORGOTTEN: Duration = Duration::from_secs(24 * 3600);

/// Removes what processes that are no more have left of `path`.
fn sweep(path: &Path) {
    let Some(name) = path.file_name().and_then(|n| n.to_str()) else { return };
    let Ok(entries) = fs::read_dir(directory(path)) else { return };
    let host = host();
    for entry in entries.flatten() {
        let file = entry.file_name();
        let writer = file.to_str().and_then(|f| f.strip_prefix(name)).and_then(|f| f.strip_prefix(PART));
        let Some(mut writer) = writer.map(|w| w.splitn(3, '-')) else { continue };
        let (of, id) = (writer.next().unwrap_or_default(), writer.next().unwrap_or_default());
        let gone = of == host && Path::new("/proc/self").exists() && !Path::new("/proc").join(id).exists();
        let age = entry.metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
        if gone || age.is_some_and(|age| age > FORGOTTEN) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let dir = std::env::temp_dir().join(format!("gonio-atomic-{}", process::id()));
        fs::create_dir_all(&dir).unwrap();
        let file = dir.join("a.nc");
        write(&file, b"old").unwrap();
        write(&file, b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(check(&file).is_ok() && check(&dir).is_err() && check(&dir.join("none/a.nc")).is_err());
        assert!(write(&dir, b"x").is_err());
        // A process that was killed has left something; one that runs is writing.
        let of = |id: u32| dir.join(format!("a.nc{PART}{}-{id}-0", host()));
        fs::write(of(u32::MAX), b"half").unwrap();
        fs::write(of(1), b"half").unwrap();
        write(&file, b"new").unwrap();
        assert!(!of(u32::MAX).exists() || !Path::new("/proc/self").exists());
        assert!(of(1).exists());
        remove(&of(1)).and_then(|()| remove(&of(1))).unwrap();
        let names: Vec<_> = fs::read_dir(&dir).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(names, ["a.nc"]);
        fs::remove_dir_all(&dir).unwrap();
    }
}

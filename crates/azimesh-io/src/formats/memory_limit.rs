//! The limit of the bytes of one input that may be held in memory. The size of a compressed file's content, or of a pipe, is
//! not known before its end, so that it is read up to a limit.

use azimesh_core::error::option;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// First size of the buffer in bytes; it doubles up to [`DOUBLED`].
const FIRST: usize = 64 << 10;
/// From this size on the buffer grows by an eighth, so that little memory stays unused.
const DOUBLED: usize = 64 << 20;
/// Without an option, a compressed file may have this many bytes of content, or [`RATIO`] times its size.
const COMPRESSED: usize = 1 << 30;
const RATIO: usize = 100;
/// Free memory that is assumed where the system does not say.
const UNKNOWN: u64 = 16 << 30;

/// The most bytes of one input that may be held in memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct MemoryLimit {
    bytes: usize,
    reason: &'static str,
}

/// Origins of the limit, with the option that changes it.
const OPTION: &str = "the limit set by {}";
const FREE: &str = "half of the free memory; {} allows more";
const PACKED: &str = "more than a mesh of this compressed size should have; {} allows more";

impl MemoryLimit {
    /// `max_memory` bytes; without it half of the free memory, since the mesh itself needs some too.
    pub fn new(max_memory: Option<u64>) -> Self {
        let bytes = max_memory.unwrap_or_else(|| free() / 2);
        Self {
            bytes: usize::try_from(bytes).unwrap_or(usize::MAX),
            reason: max_memory.map_or(FREE, |_| OPTION),
        }
    }

    /// The limit for a compressed file of `n` bytes: meshes do not compress to a hundredth, decompression bombs do.
    pub fn for_compressed(self, n: usize) -> Self {
        let bytes = n.saturating_mul(RATIO).max(COMPRESSED);
        if self.reason == OPTION || bytes >= self.bytes {
            return self;
        }
        let reason = PACKED;
        Self { bytes, reason }
    }

    /// Reads to the end and appends to `out`; an error where that exceeds the limit.
    pub fn read_all(&self, mut from: impl Read, out: &mut Vec<u8>) -> Result<()> {
        loop {
            if out.len() == out.capacity() && !self.grow(out)? {
                return match from.read(&mut [0])? {
                    0 => Ok(()),
                    _ => Err(self.exceeded()),
                };
            }
            let spare = out.capacity() - out.len();
            if from.by_ref().take(spare as u64).read_to_end(out)? < spare {
                return Ok(());
            }
        }
    }

    /// Grows the buffer; `false` where it has reached the limit.
    fn grow(&self, out: &mut Vec<u8>) -> Result<bool> {
        let held = out.len();
        let step = if held < DOUBLED { held } else { held / 8 };
        let more = step.max(FIRST).min(self.bytes.saturating_sub(held));
        out.try_reserve_exact(more)?;
        Ok(more > 0)
    }

    fn exceeded(&self) -> Error {
        let which = self.reason.replace("{}", &option("max-memory"));
        let message = format!("more than {} bytes, {which}", self.bytes);
        Error::new(ErrorKind::FileTooLarge, message)
    }
}

/// Free memory of the machine in bytes, or the limit of the control group where that is lower.
fn free() -> u64 {
    let machine = std::fs::read_to_string("/proc/meminfo").ok();
    let machine = machine.as_deref().and_then(available);
    machine.into_iter().chain(group()).min().unwrap_or(UNKNOWN)
}

/// Available bytes in the text of /proc/meminfo.
fn available(meminfo: &str) -> Option<u64> {
    let mut lines = meminfo.lines();
    let line = lines.find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes << 10)
}

/// The lowest memory limit of the control groups (v1 or v2) that this process is in.
fn group() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let limits = groups.lines().filter_map(|line| {
        let (_, rest) = line.split_once(':')?;
        let (controllers, path) = rest.split_once(':')?;
        let (root, name) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            "memory" => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            _ => return None,
        };
        let folders = Path::new(path.trim_start_matches('/')).ancestors();
        let limit = |folder: &Path| {
            let text = std::fs::read_to_string(Path::new(root).join(folder).join(name));
            text.ok()?.trim().parse::<u64>().ok()
        };
        folders.filter_map(limit).min()
    });
    limits.min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    #[test]
    fn input_is_read_up_to_the_limit() {
        let text: Vec<u8> = (0..200_000_u32).flat_map(u32::to_le_bytes).collect();
        for limit in [text.len(), text.len() + 1, 10 * text.len()] {
            let mut out = vec![7];
            let limit = MemoryLimit::new(Some(limit as u64 + 1));
            limit.read_all(&text[..], &mut out).expect("it fits");
            assert_eq!(out[1..], text);
            assert!(out.capacity() <= limit.bytes);
        }
        for limit in [0, 1, text.len() - 1] {
            let mut out = Vec::new();
            let limit = MemoryLimit::new(Some(limit as u64));
            let error = limit.read_all(&text[..], &mut out).expect_err("too large");
            assert_eq!(error.kind(), ErrorKind::FileTooLarge);
            assert_says(&error, "`max_memory`");
            assert!(out.capacity() <= limit.bytes);
        }
    }

    #[test]
    fn a_small_compressed_file_may_have_a_gigabyte_and_a_large_one_a_hundred_times_its_size() {
        let by_default = MemoryLimit {
            bytes: 16 << 30,
            reason: FREE,
        };
        assert_eq!(by_default.for_compressed(6 << 20).bytes, 1 << 30);
        assert_eq!(by_default.for_compressed(100 << 20).bytes, 10_000 << 20);
        assert_eq!(by_default.for_compressed(1 << 30).bytes, 16 << 30);
        let asked = MemoryLimit::new(Some(8 << 30));
        assert_eq!(asked.for_compressed(6 << 20).bytes, 8 << 30);
    }

    #[test]
    fn free_memory_is_what_the_system_says() {
        let text = "MemTotal:       1000 kB\nMemAvailable:   640 kB\n";
        assert_eq!(available(text), Some(640 << 10));
        assert_eq!(available("MemTotal: 1000 kB\n"), None);
        assert!(free() > 0);
    }
}

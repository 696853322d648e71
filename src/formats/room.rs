//! How much of an input may be held in memory: what is unpacked or comes from a pipe tells its size only by
//! its end, and may have none.

use crate::error::option;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// What is read takes so much at first, and twice as much each time it grows up to [`DOUBLED`].
const FIRST: usize = 64 << 10;
/// From here on it grows by an eighth, so that little is taken in vain.
const DOUBLED: usize = 64 << 20;
/// Without being asked, a packed file is unpacked to this, or to so many times its size.
const PACKED: usize = 1 << 30;
const RATIO: usize = 100;
/// Half of this where the system does not tell what is free.
const UNKNOWN: u64 = 16 << 30;

/// The most bytes that one input may have in memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    bytes: usize,
    reason: Reason,
}

/// Why it is no more.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reason {
    Asked,
    Free,
    Ratio,
}

impl Room {
    /// As much as is allowed; else half of the memory that is free, since the mesh wants some too.
    pub fn new(max_memory: Option<u64>) -> Self {
        let bytes = max_memory.unwrap_or_else(|| free() / 2);
        Self {
            bytes: usize::try_from(bytes).unwrap_or(usize::MAX),
            reason: max_memory.map_or(Reason::Free, |_| Reason::Asked),
        }
    }

    /// For a packed file of `n` bytes: a mesh does not pack to a hundredth, a bomb does.
    pub fn of_packed(self, n: usize) -> Self {
        let bytes = n.saturating_mul(RATIO).max(PACKED);
        match self.reason == Reason::Asked || bytes >= self.bytes {
            true => self,
            false => Self {
                bytes,
                reason: Reason::Ratio,
            },
        }
    }

    /// Reads to the end, behind what `out` holds.
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

    /// Whether there is room for more.
    fn grow(&self, out: &mut Vec<u8>) -> Result<bool> {
        let held = out.len();
        let step = if held < DOUBLED { held } else { held / 8 };
        let more = step.max(FIRST).min(self.bytes.saturating_sub(held));
        out.try_reserve_exact(more)?;
        Ok(more > 0)
    }

    fn exceeded(&self) -> Error {
        let which = match self.reason {
            Reason::Asked => "what {} allows",
            Reason::Free => "half of the memory that is free; {} allows more",
            Reason::Ratio => "more than meshes have that are packed to so little; {} allows more",
        };
        let which = which.replace("{}", &option("max-memory"));
        let message = format!("more than {} bytes, {which}", self.bytes);
        Error::new(ErrorKind::FileTooLarge, message)
    }
}

/// Bytes of memory that the machine has left, or the control group may have.
fn free() -> u64 {
    let machine = std::fs::read_to_string("/proc/meminfo").ok();
    let machine = machine.as_deref().and_then(available);
    machine.into_iter().chain(group()).min().unwrap_or(UNKNOWN)
}

/// What a /proc/meminfo says.
fn available(meminfo: &str) -> Option<u64> {
    let mut lines = meminfo.lines();
    let line = lines.find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes << 10)
}

/// The limit of the control group of this process (v2, or v1 with a hierarchy of its own for memory), or of
/// one that holds it.
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

    #[test]
    fn as_much_is_read_as_there_is_room_for() {
        let text: Vec<u8> = (0..200_000_u32).flat_map(u32::to_le_bytes).collect();
        for room in [text.len(), text.len() + 1, 10 * text.len()] {
            let mut out = vec![7];
            let room = Room::new(Some(room as u64 + 1));
            room.read_all(&text[..], &mut out).expect("it fits");
            assert_eq!(out[1..], text);
            assert!(out.capacity() <= room.bytes);
        }
        for room in [0, 1, text.len() - 1] {
            let mut out = Vec::new();
            let room = Room::new(Some(room as u64));
            let error = room.read_all(&text[..], &mut out).expect_err("too large");
            assert_eq!(error.kind(), ErrorKind::FileTooLarge);
            assert!(error.to_string().contains("--max-memory"), "{error}");
            assert!(out.capacity() <= room.bytes);
        }
    }

    #[test]
    fn a_small_packed_file_may_have_a_gigabyte_and_a_large_one_a_hundred_times_its_size() {
        let unasked = Room {
            bytes: 16 << 30,
            reason: Reason::Free,
        };
        assert_eq!(unasked.of_packed(6 << 20).bytes, 1 << 30);
        assert_eq!(unasked.of_packed(100 << 20).bytes, 10_000 << 20);
        assert_eq!(unasked.of_packed(1 << 30).bytes, 16 << 30);
        let asked = Room::new(Some(8 << 30));
        assert_eq!(asked.of_packed(6 << 20).bytes, 8 << 30);
    }

    #[test]
    fn free_memory_is_what_the_system_says() {
        let text = "MemTotal:       1000 kB\nMemAvailable:   640 kB\n";
        assert_eq!(available(text), Some(640 << 10));
        assert_eq!(available("MemTotal: 1000 kB\n"), None);
        assert!(free() > 0);
    }
}

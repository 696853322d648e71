//! How many threads: what is asked for, or what the batch system and the machine grant.

use std::num::NonZeroUsize;

/// Variables in which batch systems tell how many processors a task has on this machine; the first
/// that holds a number counts. Slurm, PBS, LSF, Grid Engine.
const GRANTS: [&str; 6] = [
    "SLURM_CPUS_PER_TASK",
    "SLURM_CPUS_ON_NODE",
    "NCPUS",
    "PBS_NUM_PPN",
    "LSB_DJOB_NUMPROC",
    "NSLOTS",
];

/// Where a number comes from, besides these variables.
const ASKED: &str = "--threads";
const RAYON: &str = "RAYON_NUM_THREADS";
const MACHINE: &str = "machine";
const SHARED: &str = "machine, shared by ranks";

/// A number of threads and where it comes from.
#[derive(Debug, PartialEq, Eq)]
pub struct Threads {
    /// The number.
    pub n: usize,
    /// What decided it.
    pub by: &'static str,
}

impl Threads {
    /// `asked` where given; else `RAYON_NUM_THREADS`; else what the batch system grants, if that is
    /// less than what the machine does: processors that the process may run on (affinity), within
    /// the quota of its control group. Ranks that are not bound to processors of their own share those of the machine.
    pub fn granted(asked: Option<NonZeroUsize>, n_ranks: usize) -> Self {
        let variable = |name: &str| std::env::var(name).ok();
        Self::decide(asked, machine(), variable).shared(n_ranks, is_bound())
    }

    /// What one of some ranks on a machine gets of it: all, where it is bound to processors of its own.
    fn shared(self, n_ranks: usize, is_bound: bool) -> Self {
        if self.by != MACHINE || n_ranks == 1 || is_bound {
            return self;
        }
        Self {
            n: (self.n / n_ranks).max(1),
            by: SHARED,
        }
    }

    fn decide(
        asked: Option<NonZeroUsize>,
        machine: usize,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Self {
        let number = |name: &str| {
            let n = variable(name)?.trim().parse::<usize>().ok();
            n.filter(|n| *n > 0)
        };
        if let Some(n) = asked {
            return Self::of(n.get(), ASKED);
        }
        if let Some(n) = number(RAYON) {
            return Self::of(n.min(most(machine)), RAYON);
        }
        let granted = GRANTS
            .into_iter()
            .find_map(|name| Some((number(name)?, name)));
        match granted.filter(|(n, _)| *n < machine) {
            Some((n, by)) => Self::of(n, by),
            None => Self::of(machine, MACHINE),
        }
    }

    fn of(n: usize, by: &'static str) -> Self {
        Self { n, by }
    }
}

/// Threads that the machine runs at once for this process.
fn machine() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

/// Whether this process may run on some processors of the machine only.
#[cfg(target_os = "linux")]
fn is_bound() -> bool {
    // SAFETY: the set is plain numbers, for which zeros are good, and the calls write to it alone.
    let (n, n_allowed) = unsafe {
        let mut set: libc::cpu_set_t = std::mem::zeroed();
        let found = libc::sched_getaffinity(0, size_of::<libc::cpu_set_t>(), &raw mut set);
        let n_allowed = if found == 0 { libc::CPU_COUNT(&set) } else { 0 };
        (libc::sysconf(libc::_SC_NPROCESSORS_ONLN), n_allowed)
    };
    n_allowed > 0 && i64::from(n_allowed) < n
}

#[cfg(not(target_os = "linux"))]
fn is_bound() -> bool {
    false
}

/// The most threads that are started: more than the machine runs at once cost time, and thousands take minutes.
fn most(machine: usize) -> usize {
    machine.max(256)
}

/// Reads `--threads`.
pub fn parse(text: &str) -> Result<NonZeroUsize, String> {
    let most = most(machine());
    let number = text.parse::<usize>().ok().filter(|n| *n <= most);
    number.and_then(NonZeroUsize::new).ok_or_else(|| {
        format!(
            "it must be a whole number from 1 to {most}; without it all threads that are granted are used"
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn decide(asked: usize, machine: usize, set: &[(&str, &str)]) -> (usize, &'static str) {
        let variable = |name: &str| {
            let found = set.iter().find(|(key, _)| *key == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        let threads = Threads::decide(NonZeroUsize::new(asked), machine, variable);
        (threads.n, threads.by)
    }

    #[test]
    fn what_is_asked_for_comes_before_what_is_granted() {
        let set = [("RAYON_NUM_THREADS", "3"), ("SLURM_CPUS_PER_TASK", "2")];
        assert_eq!(decide(64, 8, &set), (64, "--threads"));
        assert_eq!(decide(0, 8, &set), (3, "RAYON_NUM_THREADS"));
        assert_eq!(decide(0, 8, &set[1..]), (2, "SLURM_CPUS_PER_TASK"));
    }

    #[test]
    fn a_batch_system_grants_no_more_than_the_machine_has() {
        assert_eq!(decide(0, 4, &[("NCPUS", "16")]), (4, "machine"));
        assert_eq!(decide(0, 4, &[("NCPUS", "1")]), (1, "NCPUS"));
        assert_eq!(decide(0, 4, &[("PBS_NUM_PPN", " 2\n")]), (2, "PBS_NUM_PPN"));
        assert_eq!(
            decide(0, 4, &[("LSB_DJOB_NUMPROC", "3")]),
            (3, "LSB_DJOB_NUMPROC")
        );
        let both = [("SLURM_CPUS_ON_NODE", "3"), ("NCPUS", "1")];
        assert_eq!(decide(0, 4, &both), (3, "SLURM_CPUS_ON_NODE"));
    }

    #[test]
    fn ranks_that_are_not_bound_share_the_machine() {
        let shared = |n_ranks, is_bound| {
            let shared = Threads::of(8, MACHINE).shared(n_ranks, is_bound);
            shared.n
        };
        assert_eq!(
            [shared(1, false), shared(3, false), shared(9, false)],
            [8, 2, 1]
        );
        assert_eq!(shared(3, true), 8);
        let asked = Threads::of(8, ASKED);
        assert_eq!(asked.shared(4, false).n, 8);
    }

    #[test]
    fn a_variable_that_holds_no_number_is_not_looked_at() {
        let set = [("SLURM_CPUS_PER_TASK", "many"), ("RAYON_NUM_THREADS", "0")];
        assert_eq!(decide(0, 4, &set), (4, "machine"));
    }

    #[test]
    fn no_thread_at_all_is_refused_and_so_are_thousands() {
        assert!(parse("0").unwrap_err().contains("from 1 to"));
        for wrong in ["-1", "100000", "99999999999999999999"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        for n in [2, 256] {
            assert_eq!(parse(&n.to_string()).unwrap().get(), n);
        }
        let set = [("RAYON_NUM_THREADS", "100000")];
        assert_eq!(decide(0, 8, &set).0, 256);
        assert_eq!(decide(0, 512, &set).0, 512);
    }
}

//! The number of threads: as requested, or as granted by the batch system and the machine.

use std::num::NonZeroUsize;

/// Variables in which batch systems store the number of processors of a task on this machine; the first that holds a number
/// is used. Slurm, PBS, LSF, Grid Engine.
const GRANTS: [&str; 6] = [
    "SLURM_CPUS_PER_TASK",
    "SLURM_CPUS_ON_NODE",
    "NCPUS",
    "PBS_NUM_PPN",
    "LSB_DJOB_NUMPROC",
    "NSLOTS",
];

/// Sources of a number, besides these variables.
const ASKED: &str = "--threads";
const RAYON: &str = "RAYON_NUM_THREADS";
const MACHINE: &str = "machine";
const SHARED: &str = "machine, shared by ranks";

/// A number of threads, and its source.
pub type Threads = (usize, &'static str);

/// Returns the threads of a rank: `asked` if given; else `RAYON_NUM_THREADS`; else the number that the batch system grants, if
/// it is less than the machine's. The machine's number counts the processors on which the process may run (affinity), within
/// the quota of its control group. Ranks that are not bound to their own processors share the machine's processors.
pub fn granted(asked: Option<NonZeroUsize>, n_ranks: usize) -> Threads {
    let variable = |name: &str| std::env::var(name).ok();
    shared(decide(asked, machine(), variable), n_ranks, is_bound())
}

/// Returns the share of one of several ranks on a machine: all of it, if it is bound to its own processors.
fn shared((n, by): Threads, n_ranks: usize, is_bound: bool) -> Threads {
    if by != MACHINE || n_ranks == 1 || is_bound {
        return (n, by);
    }
    ((n / n_ranks).max(1), SHARED)
}

fn decide(
    asked: Option<NonZeroUsize>,
    machine: usize,
    variable: impl Fn(&str) -> Option<String>,
) -> Threads {
    let number = |name: &str| {
        let n = variable(name)?.trim().parse::<usize>().ok();
        n.filter(|n| *n > 0)
    };
    if let Some(n) = asked {
        return (n.get(), ASKED);
    }
    if let Some(n) = number(RAYON) {
        return (n.min(most(machine)), RAYON);
    }
    let mut grants = GRANTS.into_iter();
    let granted = grants.find_map(|name| Some((number(name)?, name)));
    let granted = granted.filter(|(n, _)| *n < machine);
    granted.unwrap_or((machine, MACHINE))
}

/// Returns the number of threads that the machine runs at once for this process.
fn machine() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

/// Checks if this process may run on only some processors of the machine.
#[cfg(target_os = "linux")]
fn is_bound() -> bool {
    // SAFETY: the set is plain numbers, for which zeros are valid, and the calls write only to it.
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

/// Largest number of threads: more than the machine runs at once cost time, and thousands take minutes.
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

    fn decide(asked: usize, machine: usize, set: &[(&str, &str)]) -> Threads {
        let variable = |name: &str| {
            let found = set.iter().find(|(key, _)| *key == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        super::decide(NonZeroUsize::new(asked), machine, variable)
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
        let shared = |n_ranks, is_bound| super::shared((8, MACHINE), n_ranks, is_bound).0;
        assert_eq!(
            [shared(1, false), shared(3, false), shared(9, false)],
            [8, 2, 1]
        );
        assert_eq!(shared(3, true), 8);
        assert_eq!(super::shared((8, ASKED), 4, false), (8, ASKED));
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

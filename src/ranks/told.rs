//! Ranks that do not run at the same time: each leaves what it tells the others, and who has that of all puts it together.

use super::{Ranks, pack, unpack};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// What a rank has told the others, one after another.
pub type Told = Vec<Vec<u8>>;

/// A rank that works while no other does.
pub(super) enum InTurn {
    /// It leaves what it tells, and hears of itself alone.
    Telling(Mutex<Told>),
    /// It has nothing of its own, and hears what each rank has left.
    Hearing(Mutex<Vec<VecDeque<Vec<u8>>>>),
}

impl Ranks {
    /// One of several that work one after another: [`told`](Self::told) is what it has for the others.
    pub fn telling() -> Self {
        Self::in_turn(InTurn::Telling(Mutex::default()))
    }

    /// One that puts together what ranks have left, by calling what they called, with nothing of its own.
    pub fn hearing(of_ranks: Vec<Told>) -> Self {
        let all = of_ranks.into_iter().map(VecDeque::from).collect();
        Self::in_turn(InTurn::Hearing(Mutex::new(all)))
    }

    /// What this rank has told since it was asked last.
    pub fn told(&self) -> Told {
        match self.in_turn.as_deref() {
            Some(InTurn::Telling(told)) => std::mem::take(&mut lock(told)),
            _ => Told::new(),
        }
    }

    fn in_turn(way: InTurn) -> Self {
        Self {
            in_turn: Some(Arc::new(way)),
            ..Self::alone()
        }
    }
}

impl InTurn {
    /// What each rank has, in their order, as far as it is known here.
    pub fn all<T: Serialize + DeserializeOwned>(&self, own: T) -> Vec<T> {
        match self {
            Self::Telling(told) => {
                lock(told).push(pack(&own));
                vec![own]
            }
            Self::Hearing(of_ranks) => {
                let mut of_ranks = lock(of_ranks);
                let next = |told: &mut VecDeque<Vec<u8>>| told.pop_front();
                let next = of_ranks.iter_mut().map(next);
                next.map(|told| unpack(&told.expect("each rank has told it")))
                    .collect()
            }
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ranks_leave_adds_up_as_if_they_were_one() {
        let parts: Vec<f64> = (0..64).map(|i| f64::from(i).sin() * 1e3).collect();
        let add = |sum: &mut f64, own: Vec<f64>| own.iter().for_each(|part| *sum += part);
        let work = |ranks: &Ranks, own: &[f64]| {
            let sum = ranks.fold(0.5, own.to_vec(), add);
            (sum, ranks.all(own.len()))
        };
        let whole = work(&Ranks::alone(), &parts).0;
        let left = [0..3, 3..40, 40..64].map(|own| {
            let ranks = Ranks::telling();
            assert_eq!(work(&ranks, &parts[own.clone()]).1, [own.len()]);
            let told = ranks.told();
            assert_eq!((told.len(), ranks.told().len()), (2, 0));
            told
        });
        let (sum, lengths) = work(&Ranks::hearing(left.to_vec()), &[]);
        assert_eq!(sum.to_bits(), whole.to_bits());
        assert_eq!(lengths, [3, 37, 24]);
    }
}

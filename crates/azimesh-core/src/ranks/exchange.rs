//! Exchanges of values between all pairs of ranks at once.

use super::{Ranks, pack, unpack};
use bytemuck::Pod;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::borrow::Cow;

impl Ranks {
    /// Sends each rank its numbers from this one, in the order of the ranks; returns the numbers from each rank for this one. The
    /// rank's own numbers are not sent.
    ///
    /// # Panics
    /// When there is not one list for each rank.
    pub fn alltoallv<T: Pod>(&self, to_each: Vec<Vec<T>>) -> Vec<Vec<T>> {
        self.in_rounds(
            to_each,
            |numbers| Cow::Borrowed(bytemuck::cast_slice(numbers)),
            &bytemuck::pod_collect_to_vec,
        )
    }

    /// Like [`alltoallv`](Self::alltoallv), for any value.
    ///
    /// # Panics
    /// When there is not one value for each rank.
    pub fn alltoall_values<T: Serialize + DeserializeOwned + Default>(
        &self,
        to_each: Vec<T>,
    ) -> Vec<T> {
        self.in_rounds(to_each, |value| pack(value).into(), &|bytes| unpack(bytes))
    }

    /// The numbers of each rank, in the order of the ranks, one list after the other, on all ranks.
    pub fn all_numbers<T: Pod>(&self, own: &[T]) -> Vec<T> {
        let of_each: Vec<Cow<'_, [T]>> = self.in_rounds(
            vec![Cow::Borrowed(own); self.n()],
            |numbers| Cow::Borrowed(bytemuck::cast_slice(numbers)),
            &|bytes| Cow::Owned(bytemuck::pod_collect_to_vec(bytes)),
        );
        of_each.concat()
    }

    /// In round `k` each rank sends to the one `k` after it, and receives from the one `k` before it. A send may wait until it is
    /// received. So in each circle of waiting ranks some have to receive first: those that send to a lower one; every circle has
    /// one.
    fn in_rounds<T: Default>(
        &self,
        mut to_each: Vec<T>,
        pack: impl Fn(&T) -> Cow<'_, [u8]>,
        unpack: &dyn Fn(&[u8]) -> T,
    ) -> Vec<T> {
        let (rank, n) = (self.rank(), self.n());
        assert_eq!(to_each.len(), n, "there is something for every rank");
        let mut from_each: Vec<T> = (0..n).map(|_| T::default()).collect();
        from_each[rank] = std::mem::take(&mut to_each[rank]);
        for k in 1..n {
            let (to, from) = ((rank + k) % n, (rank + n - k) % n);
            let value = std::mem::take(&mut to_each[to]);
            let bytes = pack(&value);
            if rank < to {
                self.send(to, &bytes);
            }
            from_each[from] = unpack(&self.receive(from));
            if rank > to {
                self.send(to, &bytes);
            }
        }
        from_each
    }
}

#[cfg(test)]
mod tests {
    use super::super::on_threads;

    #[test]
    fn every_rank_gets_what_each_has_for_it() {
        for n in 1..8 {
            let found = on_threads(n, |ranks| {
                let of = |to: usize| vec![[ranks.rank() as u32, to as u32]; ranks.rank() + 2 * to];
                let numbers = ranks.alltoallv((0..n).map(of).collect());
                let names = (0..n).map(|to| format!("{} to {to}", ranks.rank()));
                (numbers, ranks.alltoall_values(names.collect()))
            });
            for (rank, (numbers, names)) in found.into_iter().enumerate() {
                for from in 0..n {
                    let wanted = vec![[from as u32, rank as u32]; from + 2 * rank];
                    assert_eq!(numbers[from], wanted, "{from} to {rank} of {n}");
                    assert_eq!(names[from], format!("{from} to {rank}"));
                }
            }
        }
    }

    #[test]
    fn every_rank_gets_the_numbers_of_all_in_the_order_of_the_ranks() {
        for n in 1..8 {
            let of = |rank: usize| vec![0.1 + rank as f64; (rank * 5) % 3];
            let wanted: Vec<f64> = (0..n).flat_map(of).collect();
            let found = on_threads(n, |ranks| ranks.all_numbers(&of(ranks.rank())));
            assert!(found.into_iter().all(|found| found == wanted));
        }
    }

    #[test]
    fn what_is_exchanged_is_counted() {
        let sent = on_threads(3, |ranks| {
            ranks.set_label("numbers");
            ranks.alltoallv(vec![vec![7u64; 2]; 3]);
            ranks.sent_by_all()
        });
        let numbers = &sent[0][0];
        assert_eq!((numbers.messages, numbers.bytes, numbers.most), (6, 96, 32));
    }
}

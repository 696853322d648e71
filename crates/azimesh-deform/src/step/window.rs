//! Steps that are repaired together: a window is a run of folded steps and some steps before and after it, over which the
//! repair grows and fades. Where steps were added to a finished run, it begins at the positions of the last finished step.
//!
//! A window depends only on which steps are folded: every step in it finds the same window.

use super::substeps::Parts;
use azimesh_core::error::Result;
use azimesh_quality::repair::Area;
use std::ops::Range;

/// Number of steps over which a repair grows, and over which it fades.
pub(crate) const FADE: usize = 5;

/// Steps that are repaired together.
#[derive(Debug)]
pub(crate) struct Window {
    /// Its steps.
    pub steps: Range<usize>,
    /// True if cells of low quality are improved: steps with such cells then count as folded.
    pub improves: bool,
    /// Its folded steps, ascending.
    pub folded: Vec<usize>,
    /// The substeps of every step; `None` if they do not help.
    pub substeps: Option<Parts>,
    /// The area in which nodes move; only on the first rank, which has the whole mesh.
    pub area: Option<Area>,
}

impl Window {
    /// Creates the window of steps without folded cells that follow a repaired step of a finished run.
    pub fn after_seam(steps: Range<usize>) -> Self {
        Self {
            steps,
            improves: false,
            folded: Vec::new(),
            substeps: None,
            area: None,
        }
    }

    /// Returns the weight of the repair at a step: 1 at a folded step, less with the distance from it.
    pub fn weight(&self, step: usize) -> f64 {
        let distances = self.folded.iter().map(|&folded| folded.abs_diff(step));
        faded(distances.min().unwrap_or(FADE + 1))
    }
}

/// Returns the weight at a distance in steps: from 1 to 0, smoothly.
pub(crate) fn faded(distance: usize) -> f64 {
    let part = (FADE + 1 - distance.min(FADE + 1)) as f64 / (FADE + 1) as f64;
    part * part * (3.0 - 2.0 * part)
}

/// Returns the steps of the window of some folded steps, limited to `within`.
pub(crate) fn steps_around(folded: &[usize], within: &Range<usize>) -> Range<usize> {
    match (folded.first(), folded.last()) {
        (Some(first), Some(last)) => {
            let first = first.saturating_sub(FADE).max(within.start);
            first..(last + FADE + 1).min(within.end)
        }
        _ => 0..0,
    }
}

/// Returns the folded steps of the window that contains a step, ascending; empty if there is none. Checks the steps near
/// it, and from each folded one as far as another could share a window with it, but never outside `within`.
pub(crate) fn folded_around(
    step: usize,
    within: &Range<usize>,
    is_folded: &mut dyn FnMut(usize) -> Result<bool>,
) -> Result<Vec<usize>> {
    let near = step.saturating_sub(FADE).max(within.start)..(step + FADE + 1).min(within.end);
    let mut folded = Vec::new();
    for near in near {
        if is_folded(near)? {
            folded.push(near);
        }
    }
    let (Some(&first), Some(&last)) = (folded.first(), folded.last()) else {
        return Ok(folded);
    };
    let mut before = Vec::new();
    let (mut at, mut left) = (first, 2 * FADE);
    while at > within.start && left > 0 {
        (at, left) = (at - 1, left - 1);
        if is_folded(at)? {
            before.push(at);
            left = 2 * FADE;
        }
    }
    let (mut at, mut left) = (last + 1, 2 * FADE);
    while at < within.end && left > 0 {
        if is_folded(at)? {
            folded.push(at);
            left = 2 * FADE + 1;
        }
        (at, left) = (at + 1, left - 1);
    }
    before.reverse();
    before.extend(folded);
    Ok(before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Returns the window of a step, and the steps that were checked.
    fn window(
        step: usize,
        within: Range<usize>,
        folded: &[usize],
    ) -> (Vec<usize>, BTreeSet<usize>) {
        let mut seen = BTreeSet::new();
        let found = folded_around(step, &within, &mut |step| {
            assert!(within.contains(&step));
            seen.insert(step);
            Ok(folded.contains(&step))
        });
        (found.expect("nothing fails"), seen)
    }

    #[test]
    fn every_step_of_a_window_finds_the_same_one() {
        let all = [3, 20, 21, 23, 30, 40, 51, 80];
        // From 40 to 51 the fades do not meet; from 30 to 40 they share a step.
        let windows: [&[usize]; 4] = [&[3], &[20, 21, 23, 30, 40], &[51], &[80]];
        for wanted in windows {
            for step in steps_around(wanted, &(0..83)) {
                assert_eq!(window(step, 0..83, &all).0, wanted, "{step}");
            }
        }
        for step in [9, 14, 57, 74] {
            assert_eq!(window(step, 0..83, &all).0, [0; 0], "{step}");
        }
        assert_eq!(steps_around(&[3], &(0..83)), 0..9);
        assert_eq!(steps_around(&[80], &(0..83)), 75..83);
    }

    #[test]
    fn no_window_leaves_its_range() {
        assert_eq!(window(12, 10..20, &[8, 11, 21]).0, [11]);
        assert_eq!(steps_around(&[11], &(10..20)), 10..17);
    }

    #[test]
    fn far_from_folds_only_the_steps_of_a_fade_are_looked_at() {
        let (found, seen) = window(30, 0..100, &[]);
        assert!(found.is_empty());
        assert_eq!(seen, (30 - FADE..=30 + FADE).collect());
    }

    #[test]
    fn a_repair_grows_and_fades_over_the_steps_around_it() {
        let window = Window {
            steps: 15..29,
            improves: false,
            folded: vec![20, 23],
            substeps: None,
            area: None,
        };
        let weights: Vec<f64> = (14..=29).map(|step| window.weight(step)).collect();
        assert_eq!([weights[0], weights[15]], [0.0, 0.0]);
        assert_eq!([weights[6], weights[9]], [1.0, 1.0]);
        assert!(weights[..7].windows(2).all(|pair| pair[0] < pair[1]));
        assert!(weights[9..].windows(2).all(|pair| pair[0] > pair[1]));
        assert!(weights[7] < 1.0 && weights[7] == weights[8]);
    }
}

//! Choice of the steps that have a still picture: those that differ most in the positions of the bodies, and the one with
//! the worst cell.

use super::scene::Pose;

/// Largest number of still pictures besides the first.
const PICTURES: usize = 4;
/// Poses that differ by less than this part of the largest motion are the same picture.
const SAME: f64 = 0.08;

/// Returns indices of poses, ascending: the first, the worst, the one farthest from the first, then always the one that is
/// farthest from all so far.
pub fn stills(poses: &[Pose], worst: Option<usize>) -> Vec<usize> {
    let Some(start) = poses.first() else {
        return Vec::new();
    };
    let from_start: Vec<f64> = poses.iter().map(|pose| distance(pose, start)).collect();
    let largest = from_start.iter().copied().fold(0.0, f64::max);
    let mut nearest = from_start.clone();
    let mut chosen = vec![0];
    let mut wanted = worst;
    while chosen.len() <= PICTURES {
        let is_new = |&pose: &usize| nearest[pose] > SAME * largest;
        let Some(pose) = wanted.or_else(|| farthest(&nearest).filter(is_new)) else {
            break;
        };
        if !chosen.contains(&pose) {
            chosen.push(pose);
        }
        for (least, other) in nearest.iter_mut().zip(poses) {
            *least = least.min(distance(other, &poses[pose]));
        }
        wanted = farthest(&from_start).filter(|&extreme| nearest[extreme] > SAME * largest);
    }
    chosen.sort_unstable();
    chosen
}

/// The first of the largest, where a thousandth is no difference.
fn farthest(distances: &[f64]) -> Option<usize> {
    let largest = distances.iter().copied().reduce(f64::max)?;
    distances
        .iter()
        .position(|distance| *distance >= 0.999 * largest)
}

/// Root mean square of the distances of points.
fn distance(a: &Pose, b: &Pose) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| {
        let along = |axis: usize| f64::from(a[axis] - b[axis]);
        along(0).powi(2) + along(1).powi(2) + along(2).powi(2)
    });
    (squares.sum::<f64>() / a.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses(heights: impl IntoIterator<Item = f64>) -> Vec<Pose> {
        let of = |height: f64| vec![[0.0; 3], [1.0, height as f32, 0.0]];
        heights.into_iter().map(of).collect()
    }

    /// Four steps spread evenly over this motion are at 0.5, 0, -0.5 and 0.
    #[test]
    fn no_position_is_shown_twice() {
        let poses = poses((0..=40).map(|i| (f64::from(i) * 0.1 * std::f64::consts::PI).sin()));
        let height = |pose: usize| poses[pose][1][1];
        let chosen = stills(&poses, Some(7));
        assert_eq!(chosen.len(), 5);
        assert!(chosen.contains(&0) && chosen.contains(&7));
        for (at, &one) in chosen.iter().enumerate() {
            for &other in &chosen[at + 1..] {
                assert!((height(one) - height(other)).abs() > 0.1, "{chosen:?}");
            }
            assert!(
                [0, 7].contains(&one) || height(one).abs() > 0.1,
                "{chosen:?}"
            );
        }
        let largest = chosen.iter().map(|&pose| height(pose)).fold(0.0, f32::max);
        assert!(largest > 0.99, "{largest}");
    }

    #[test]
    fn what_does_not_move_has_one_picture() {
        let poses = poses([0.0; 9]);
        assert_eq!(stills(&poses, Some(5)), [0, 5]);
        assert_eq!(stills(&poses, None), [0]);
        assert!(stills(&[], None).is_empty());
    }
}

//! Which steps have a picture of their own: those that differ most in where the bodies are, and the one with the worst
//! cell.

use super::pack::Pose;

/// Pictures of steps, at most.
const PICTURES: usize = 4;
/// Poses that differ by less than this part of the largest motion are the same picture.
const SAME: f64 = 0.08;

/// Indices of frames, ascending: the worst one, the one farthest from the reference mesh, then always the one that is
/// farthest from all pictures so far. `rest` is the reference mesh, which is shown as well, where it is known.
pub fn stills(rest: Option<&Pose>, frames: &[Pose], worst: Option<usize>) -> Vec<usize> {
    let Some(start) = rest.or(frames.first()) else {
        return Vec::new();
    };
    let from_start: Vec<f64> = frames.iter().map(|pose| distance(pose, start)).collect();
    let largest = from_start.iter().copied().fold(0.0, f64::max);
    let mut nearest = from_start.clone();
    let mut chosen = Vec::new();
    if rest.is_none() {
        chosen.push(0);
    }
    let mut wanted = worst;
    while chosen.len() < PICTURES {
        let frame = wanted.or_else(|| farthest(&nearest));
        let Some(frame) =
            frame.filter(|&frame| wanted.is_some() || nearest[frame] > SAME * largest)
        else {
            break;
        };
        if !chosen.contains(&frame) {
            chosen.push(frame);
        }
        for (least, pose) in nearest.iter_mut().zip(frames) {
            *least = least.min(distance(pose, &frames[frame]));
        }
        let extreme = farthest(&from_start).filter(|&extreme| nearest[extreme] > SAME * largest);
        wanted = extreme;
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
        let frames = poses((0..=40).map(|i| (f64::from(i) * 0.1 * std::f64::consts::PI).sin()));
        let rest = poses([0.0]);
        let height = |frame: usize| frames[frame][1][1];
        let chosen = stills(Some(&rest[0]), &frames, Some(7));
        assert_eq!(chosen.len(), 4);
        assert!(chosen.contains(&7));
        for (at, &one) in chosen.iter().enumerate() {
            for &other in &chosen[at + 1..] {
                assert!((height(one) - height(other)).abs() > 0.1, "{chosen:?}");
            }
            assert!(one == 7 || height(one).abs() > 0.1, "{chosen:?}");
        }
        let largest = chosen
            .iter()
            .map(|&frame| height(frame))
            .fold(0.0, f32::max);
        assert!(largest > 0.99, "{largest}");
    }

    #[test]
    fn what_does_not_move_has_one_picture() {
        let frames = poses([0.0; 9]);
        assert_eq!(stills(Some(&frames[0]), &frames, Some(5)), [5]);
        assert_eq!(stills(None, &frames, None), [0]);
        assert!(stills(None, &[], None).is_empty());
    }
}

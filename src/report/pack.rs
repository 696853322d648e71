//! Positions and triangles in few bytes, for the script of the page to unpack.
//!
//! A coordinate is one of 65536 steps between the ends of a part's box over all frames. Of each coordinate the change since
//! the frame before is stored, less that of the vertex before, which is near; then low and high bytes apart, which zlib
//! compresses well. `unpackPositions` in `scene.js` is the inverse.

use super::embed::embedded;
use super::surface::Surface;
use azimesh_core::geometry::Bounds;
use serde_json::{Value, json};

/// Steps between the ends of a box.
const STEPS: f64 = 65535.0;

/// Single-precision coordinates, one for each vertex.
pub type Pose = Vec<[f32; 3]>;

/// The triangles of a surface: corner by corner the distance from the corner before, in four planes of bytes.
pub fn triangles(surface: &Surface) -> String {
    let corners = surface
        .triangles
        .iter()
        .flat_map(|triangle| triangle.corners);
    let mut before = 0u32;
    let steps: Vec<u32> = corners
        .map(|corner| {
            let step = corner.wrapping_sub(before) as i32;
            before = corner;
            ((step << 1) ^ (step >> 31)) as u32
        })
        .collect();
    let plane = |shift: u32| steps.iter().map(move |step| (step >> shift) as u8);
    let bytes: Vec<u8> = [0, 8, 16, 24].into_iter().flat_map(plane).collect();
    embedded(&bytes)
}

/// The boxes of the parts over all frames, low end and length of a step for each axis, and the packed frames.
pub fn positions(surface: &Surface, frames: &[Pose]) -> (Vec<Value>, String) {
    let mut boxes = Vec::new();
    let mut scales = vec![([0.0; 3], [0.0; 3]); surface.vertices.len()];
    for part in &surface.parts {
        let points = frames.iter().flat_map(|pose| &pose[part.vertices.clone()]);
        let points: Vec<[f64; 3]> = points.map(|x| x.map(f64::from)).collect();
        let bounds = if points.is_empty() {
            Bounds {
                low: [0.0; 3],
                high: [0.0; 3],
            }
        } else {
            Bounds::around(&points)
        };
        let step = [0, 1, 2].map(|axis| (bounds.high[axis] - bounds.low[axis]) / STEPS);
        scales[part.vertices.clone()].fill((bounds.low, step));
        boxes.push(json!({ "low": bounds.low, "step": step }));
    }
    let n = surface.vertices.len();
    let mut bytes = Vec::with_capacity(6 * n * frames.len());
    let mut before = vec![[0u16; 3]; n];
    for pose in frames {
        let steps: Vec<[u16; 3]> = pose
            .iter()
            .zip(&scales)
            .map(|(x, scale)| quantized(*x, *scale))
            .collect();
        for axis in 0..3 {
            let mut last = 0u16;
            let differences = steps.iter().zip(&before).map(|(now, before)| {
                let change = now[axis].wrapping_sub(before[axis]);
                let difference = change.wrapping_sub(last) as i16;
                last = change;
                ((difference << 1) ^ (difference >> 15)) as u16
            });
            let differences: Vec<u16> = differences.collect();
            bytes.extend(differences.iter().map(|difference| *difference as u8));
            bytes.extend(differences.iter().map(|difference| (difference >> 8) as u8));
        }
        before = steps;
    }
    (boxes, embedded(&bytes))
}

fn quantized(x: [f32; 3], (low, step): ([f64; 3], [f64; 3])) -> [u16; 3] {
    [0, 1, 2].map(|axis| match step[axis] > 0.0 {
        true => ((f64::from(x[axis]) - low[axis]) / step[axis])
            .round()
            .clamp(0.0, STEPS) as u16,
        false => 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::BodyRecord;
    use crate::report::embed::unembedded;
    use crate::report::surface::Surfaces;
    use azimesh_io::mesh::Mesh;
    use std::path::Path;

    fn wing() -> Surface {
        let mesh = Mesh::read(Path::new("testdata/wing_on_plane.vtu")).expect("it is good");
        let body = BodyRecord {
            name: "wing".into(),
            tags: vec!["wing".into()],
            ..BodyRecord::default()
        };
        Surfaces::new(&mesh, &[body], 300)
            .expect("it has a wing")
            .bodies
    }

    /// As `scene.js` does it.
    #[test]
    fn positions_come_back_to_half_a_step() {
        let surface = wing();
        let n = surface.vertices.len();
        let pose = |frame: usize| -> Pose {
            let bend = |x: &[f64; 3]| [x[0], x[1] + 0.1 * (frame as f64).sin() * x[2] * x[2], x[2]];
            surface
                .points
                .iter()
                .map(|x| bend(x).map(|x| x as f32))
                .collect()
        };
        let frames: Vec<Pose> = (0..5).map(pose).collect();
        let (boxes, text) = positions(&surface, &frames);
        let bytes = unembedded(&text);
        assert_eq!(bytes.len(), 5 * n * 6);
        let of = |key: &str, axis: usize| boxes[0][key][axis].as_f64().expect("a number");
        let mut now = vec![[0u16; 3]; n];
        let mut planes = bytes.chunks(n);
        for frame in &frames {
            for axis in 0..3 {
                let (low, high) = (planes.next().expect("low"), planes.next().expect("high"));
                let mut change = 0u16;
                for (i, x) in now.iter_mut().enumerate() {
                    let coded = u16::from_le_bytes([low[i], high[i]]);
                    change = change.wrapping_add((coded >> 1) ^ 0u16.wrapping_sub(coded & 1));
                    x[axis] = x[axis].wrapping_add(change);
                    let step = of("step", axis);
                    let found = of("low", axis) + step * f64::from(x[axis]);
                    assert!(
                        (found - f64::from(frame[i][axis])).abs() <= 0.501 * step,
                        "{i} {axis}"
                    );
                }
            }
        }
    }

    #[test]
    fn triangles_come_back() {
        let surface = wing();
        let bytes = unembedded(&triangles(&surface));
        let n = bytes.len() / 4;
        let mut last = 0u32;
        let corners = (0..n).map(|i| {
            let coded = u32::from_le_bytes([0, 1, 2, 3].map(|plane| bytes[plane * n + i]));
            last = last.wrapping_add((coded >> 1) ^ 0u32.wrapping_sub(coded & 1));
            last
        });
        let corners: Vec<u32> = corners.collect();
        let given: Vec<u32> = surface
            .triangles
            .iter()
            .flat_map(|triangle| triangle.corners)
            .collect();
        assert!(given.len() > 600 && given.len() <= 900, "{}", given.len());
        assert_eq!(corners, given);
    }
}

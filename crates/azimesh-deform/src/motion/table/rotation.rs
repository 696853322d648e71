//! The forms that rotations have in a table: three angles in an order, rotation vectors, quaternions, Wiener-Milenkovic
//! parameters.

use super::{Column, Columns, Table};
use crate::motion::keys::names;
use azimesh_core::error::Result;
use azimesh_core::geometry::rotation::Quaternion;
use azimesh_core::geometry::vector::{Vector, norm, scale};
use azimesh_core::numbers::short;
use std::sync::Arc;

/// By how much the length of a quaternion may differ from 1: tables of a few digits have such.
const OFF_UNIT: f64 = 1e-3;

/// Form of the rotations in a table. A rotation turns a body, right-handed, from its place in the reference mesh.
///
/// The names of the orders are of intrinsic rotations: with `EulerZyx` the body turns about z, then about its own y, then
/// about its own x, which is the same as turning about x, then y, then z of the fixed axes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RotationForm {
    /// Angles `rot_x`, `rot_y`, `rot_z`: `R = Rx Ry Rz`.
    EulerXyz,
    /// `R = Rx Rz Ry`.
    EulerXzy,
    /// `R = Ry Rx Rz`.
    EulerYxz,
    /// `R = Ry Rz Rx`.
    EulerYzx,
    /// `R = Rz Rx Ry`.
    EulerZxy,
    /// `R = Rz Ry Rx`, the default: yaw, pitch and roll.
    #[default]
    EulerZyx,
    /// Angles `rot_1`, `rot_2`, `rot_3`: `R = Rx Ry Rx`, with the first angle on the left.
    EulerXyx,
    /// `R = Rx Rz Rx`.
    EulerXzx,
    /// `R = Ry Rx Ry`.
    EulerYxy,
    /// `R = Ry Rz Ry`.
    EulerYzy,
    /// `R = Rz Rx Rz`.
    EulerZxz,
    /// `R = Rz Ry Rz`.
    EulerZyz,
    /// A rotation vector `rot_x`, `rot_y`, `rot_z`: the axis times the angle.
    Vector,
    /// `quat_w`, `quat_x`, `quat_y`, `quat_z`: `cos(angle / 2)` and the axis times `sin(angle / 2)`.
    Quaternion,
    /// `wm_x`, `wm_y`, `wm_z`: the axis times `4 tan(angle / 4)`, as in OpenFAST's BeamDyn.
    WienerMilenkovic,
}

names! {
    RotationForm {
        "euler_xyz" => EulerXyz, "euler_xzy" => EulerXzy, "euler_yxz" => EulerYxz,
        "euler_yzx" => EulerYzx, "euler_zxy" => EulerZxy, "euler_zyx" => EulerZyx,
        "euler_xyx" => EulerXyx, "euler_xzx" => EulerXzx, "euler_yxy" => EulerYxy,
        "euler_yzy" => EulerYzy, "euler_zxz" => EulerZxz, "euler_zyz" => EulerZyz,
        "vector" => Vector, "quaternion" => Quaternion, "wiener_milenkovic" => WienerMilenkovic
    }
}

impl RotationForm {
    /// Returns the fixed axes that angles about three axes turn about, in their order; `None` for one rotation about one axis,
    /// which angles about two axes become.
    pub fn order(self) -> Option<[usize; 3]> {
        Some(match self {
            Self::EulerXyz => [2, 1, 0],
            Self::EulerXzy => [1, 2, 0],
            Self::EulerYxz => [2, 0, 1],
            Self::EulerYzx => [0, 2, 1],
            Self::EulerZxy => [1, 0, 2],
            Self::EulerZyx => [0, 1, 2],
            _ => return None,
        })
    }

    /// Returns the axes of three angles, the first and last about the same axis.
    fn proper(self) -> Option<[Vector; 3]> {
        let [outer, inner] = match self {
            Self::EulerXyx => [0, 1],
            Self::EulerXzx => [0, 2],
            Self::EulerYxy => [1, 0],
            Self::EulerYzy => [1, 2],
            Self::EulerZxz => [2, 0],
            Self::EulerZyz => [2, 1],
            _ => return None,
        };
        let axis = |axis: usize| std::array::from_fn(|i| f64::from(u8::from(i == axis)));
        Some([outer, inner, outer].map(axis))
    }

    /// Returns whether it becomes rotation vectors.
    fn is_converted(self) -> bool {
        matches!(self, Self::Quaternion | Self::WienerMilenkovic) || self.proper().is_some()
    }

    /// Returns the names of the columns about x, y and z, or of three angles in their order.
    pub fn columns(self) -> [&'static str; 3] {
        match self {
            Self::Quaternion => ["quat_x", "quat_y", "quat_z"],
            Self::WienerMilenkovic => ["wm_x", "wm_y", "wm_z"],
            _ if self.proper().is_some() => ["rot_1_deg", "rot_2_deg", "rot_3_deg"],
            _ => ["rot_x_deg", "rot_y_deg", "rot_z_deg"],
        }
    }

    /// Returns the entry `rotation` that a column needs, if it has another form.
    pub fn needed_for(self, column: &str) -> Option<&'static str> {
        let is_numbered = column.starts_with("rot_") && column[4..].starts_with(['1', '2', '3']);
        match column.split('_').next()? {
            "quat" if self != Self::Quaternion => Some("rotation = \"quaternion\""),
            "wm" if self != Self::WienerMilenkovic => Some("rotation = \"wiener_milenkovic\""),
            "rot" if is_numbered && self.proper().is_none() => {
                Some("rotation = \"euler_zxz\", or another order with one axis twice")
            }
            "rot" if !is_numbered && self.is_converted() => {
                Some("rotation = \"vector\", or an order of angles such as \"euler_zyx\"")
            }
            _ => None,
        }
    }

    /// Picks the columns; those that may be left out are 0.
    pub fn pick(self, columns: &mut Columns<'_>) -> Result<Vec<Option<Column>>> {
        match self {
            Self::Quaternion => {
                let names = ["quat_w", "quat_x", "quat_y", "quat_z"].into_iter();
                names.map(|name| columns.require(name).map(Some)).collect()
            }
            Self::WienerMilenkovic => {
                let names = self.columns().into_iter();
                Ok(names.map(|name| columns.optional(name)).collect())
            }
            _ => {
                let names = self.columns().into_iter();
                let stems = names.map(|name| name.trim_end_matches("_deg"));
                stems.map(|stem| columns.optional_angle(stem)).collect()
            }
        }
    }

    /// Converts quaternions, parameters and angles about two axes to rotation vectors, in a new table; also returns the columns of these, or of angles as they are.
    /// Vectors are unwrapped from row to row where rows `follow` one another, else they are at most half a turn long.
    ///
    /// # Errors
    /// When a quaternion has not the length 1.
    pub fn vectors(
        self,
        table: Arc<Table>,
        picked: &[Option<Column>],
        follow: bool,
    ) -> Result<(Arc<Table>, [Option<Column>; 3])> {
        let none_given = picked.iter().all(Option::is_none);
        if none_given || !self.is_converted() {
            return Ok((table, std::array::from_fn(|i| picked[i])));
        }
        let mut vectors: Vec<Vector> = Vec::with_capacity(table.n_rows());
        for row in 0..table.n_rows() {
            let value =
                |column: &Option<Column>| column.map_or(0.0, |column| table.value(row, column));
            let values: Vec<f64> = picked.iter().map(value).collect();
            let q = match (&values[..], self.proper()) {
                (&[a, b, c], Some(axes)) => {
                    let [a, b, c] = [(0, a), (1, b), (2, c)]
                        .map(|(i, angle)| Quaternion::rotation(axes[i], angle));
                    c.then(b).then(a)
                }
                (&[w, x, y, z], _) => {
                    let length = w.hypot(x).hypot(y).hypot(z);
                    // Also where it is too large for a number.
                    if (length - 1.0).abs() <= OFF_UNIT {
                        Quaternion {
                            w: w / length,
                            v: scale([x, y, z], 1.0 / length),
                        }
                    } else {
                        let remedy = if length == 0.0 {
                            "no rotation is 1, 0, 0, 0"
                        } else {
                            "divide its components by their length"
                        };
                        let message = format!(
                            "the quaternion has the length {}; it must be 1, to {OFF_UNIT}: {remedy}",
                            short(length)
                        );
                        return Err(table.error(row, message));
                    }
                }
                _ => of_parameters([values[0], values[1], values[2]]),
            };
            let near = vectors.last().copied().filter(|_| follow);
            vectors.push(q.nearest_vector(near.unwrap_or([0.0; 3])));
        }
        let (table, columns) = table.with_angles(["rot_x", "rot_y", "rot_z"], &vectors);
        Ok((Arc::new(table), columns.map(Some)))
    }
}

/// The rotation of Wiener-Milenkovic parameters, axis times `4 tan(angle / 4)`.
fn of_parameters(c: Vector) -> Quaternion {
    let length = norm(c);
    let half = 2.0 * (length / 4.0).atan();
    // The sine of half the angle over the length of the parameters, which is 1/2 where they are 0.
    let part = if length > 0.0 {
        half.sin() / length
    } else {
        0.5
    };
    Quaternion {
        w: half.cos(),
        v: scale(c, part),
    }
}

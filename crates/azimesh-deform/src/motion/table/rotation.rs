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
        "vector" => Vector, "quaternion" => Quaternion, "wiener_milenkovic" => WienerMilenkovic
    }
}

impl RotationForm {
    /// Returns the fixed axes that three angles turn about, in their order; `None` for one rotation about one axis.
    pub fn order(self) -> Option<[usize; 3]> {
        Some(match self {
            Self::EulerXyz => [2, 1, 0],
            Self::EulerXzy => [1, 2, 0],
            Self::EulerYxz => [2, 0, 1],
            Self::EulerYzx => [0, 2, 1],
            Self::EulerZxy => [1, 0, 2],
            Self::EulerZyx => [0, 1, 2],
            Self::Vector | Self::Quaternion | Self::WienerMilenkovic => return None,
        })
    }

    /// Returns the names of the columns about x, y and z.
    pub fn columns(self) -> [&'static str; 3] {
        match self {
            Self::Quaternion => ["quat_x", "quat_y", "quat_z"],
            Self::WienerMilenkovic => ["wm_x", "wm_y", "wm_z"],
            _ => ["rot_x_deg", "rot_y_deg", "rot_z_deg"],
        }
    }

    /// Returns the entry `rotation` that a column needs, if it has another form.
    pub fn needed_for(self, column: &str) -> Option<&'static str> {
        let is_angle = !matches!(self, Self::Quaternion | Self::WienerMilenkovic);
        match column.split('_').next()? {
            "quat" if self != Self::Quaternion => Some("rotation = \"quaternion\""),
            "wm" if self != Self::WienerMilenkovic => Some("rotation = \"wiener_milenkovic\""),
            "rot" if !is_angle => {
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
                let stems = ["rot_x", "rot_y", "rot_z"].into_iter();
                stems.map(|stem| columns.optional_angle(stem)).collect()
            }
        }
    }

    /// Converts quaternions and parameters to rotation vectors, in a new table; also returns the columns of these, or of angles as they are.
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
        if none_given || !matches!(self, Self::Quaternion | Self::WienerMilenkovic) {
            return Ok((table, std::array::from_fn(|i| picked[i])));
        }
        let mut vectors: Vec<Vector> = Vec::with_capacity(table.n_rows());
        for row in 0..table.n_rows() {
            let value =
                |column: &Option<Column>| column.map_or(0.0, |column| table.value(row, column));
            let values: Vec<f64> = picked.iter().map(value).collect();
            let q = match values[..] {
                [w, x, y, z] => {
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

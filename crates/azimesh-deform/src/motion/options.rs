//! `[rbf]` and `[selection]`: options of the interpolation and of the base points.

use super::keys::{Kind, Named, boolean, choice, count, keys, names, numbers, positive};
use super::places::Places;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;
use serde_json::json;

/// Largest number of substeps of a step.
const MAX_SUBSTEPS: usize = 1000;

/// Radial basis functions by name.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Kernel, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0]))
///     .kernel(Kernel::WendlandC4)
///     .support_radius(5.0);
/// assert_eq!(Kernel::default(), Kernel::WendlandC2);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(missing_docs)] // the names say it
pub enum KernelName {
    WendlandC0,
    #[default]
    WendlandC2,
    WendlandC4,
    WendlandC6,
}

impl KernelName {
    /// Its name in a schedule.
    pub fn name(self) -> &'static str {
        Self::names()[self as usize].0
    }
}

names! {
    KernelName { "wendland-c0" => WendlandC0, "wendland-c2" => WendlandC2, "wendland-c4" => WendlandC4, "wendland-c6" => WendlandC6 }
    Polynomial { "none" => None, "linear" => Linear }
    Interpolate { "displacement" => Displacement, "twist" => Twist }
    SelectionMethod { "sequence" => Sequence, "constant" => Constant, "real" => Real, "all" => All }
    SelectionCriterion { "max" => Max, "mean" => Mean }
}

/// Polynomial added to the radial basis functions.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Polynomial, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0])).polynomial(Polynomial::Linear);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Polynomial {
    /// None: the mesh is at rest out of reach of the base points.
    #[default]
    None,
    /// `p0 + p1 x + p2 y + p3 z`, so that an affine motion is reproduced everywhere.
    Linear,
}

/// Quantity that is interpolated into the volume.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Interpolate, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0])).interpolate(Interpolate::Twist);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolate {
    /// The displacement of surface nodes.
    #[default]
    Displacement,
    /// The rotation vector and the translation of bodies.
    Twist,
}

keys! {
    /// `[rbf]`: the interpolation.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RbfOptions "[rbf]" {
        /// radial basis function
        pub kernel: KernelName, choice::<KernelName>(), default "wendland-c2";
        /// greater than 1e-9 of the diagonal of the mesh. Default: the smaller of the diagonal of the deforming region
        /// and ten diagonals of the box around the moving tags
        pub support_radius: Option<f64>, positive("length"), or "chosen and reported";
        /// `"linear"` adds `p0 + p1 x + p2 y + p3 z`, which reproduces an affine motion of all surfaces everywhere;
        /// refused with [sliding or periodic](boundaries.md) boundaries
        pub polynomial: Polynomial, choice::<Polynomial>(), default "none";
        /// displacements, or the rotation vector and translation of each body. `"twist"` is for rotations of more than
        /// about 60 degrees against a fixed boundary, up to about 300; `"displacement"` for large translations in
        /// narrow gaps, and for a small body close to a fixed one ([a flap](rotations.md#a-flap-next-to-a-fixed-wing)).
        /// With twist on a beam every section turns about its point of the lifting line (no substeps); `surface` and
        /// `modes` have no rotations and are refused
        pub interpolate: Interpolate, choice::<Interpolate>(), default "displacement";
        /// greater than 0, with `"twist"` only: support radius of the rotation. Without this key the rotation of a
        /// rigid body inside a fixed circle or cylinder decreases with the logarithm of the distance from its axis
        /// ([method](method.md#7-large-rotations))
        pub rotation_radius: Option<f64>, positive("length"), or "`support_radius`";
        /// number of parts of each step: angles and translations grow evenly over the parts, and each part deforms the
        /// mesh of the previous one. For motions that fold cells in one step; the time per step is proportional
        pub substeps: usize, SUBSTEPS, default 1;
    }
}

const SUBSTEPS: Kind<usize> = Kind {
    schema: || json!({ "type": "integer", "minimum": 1, "maximum": MAX_SUBSTEPS }),
    ..count("integer, 1 to 1000")
};

impl RbfOptions {
    /// Refuses invalid numbers, and options that exclude each other.
    pub(super) fn check(&self, places: &Places) -> Result<()> {
        if let Some(radius) = self.support_radius {
            places.positive("rbf.support_radius", radius)?;
        }
        if let Some(radius) = self.rotation_radius {
            if self.interpolate != Interpolate::Twist {
                let message = "`rotation_radius` needs interpolate = \"twist\"; set that, or leave the key out";
                return Err(places.error("rbf.rotation_radius", message));
            }
            places.positive("rbf.rotation_radius", radius)?;
        }
        let n = self.substeps;
        if !(1..=MAX_SUBSTEPS).contains(&n) {
            let message = format!("`substeps` is {n}; at most {MAX_SUBSTEPS} are possible");
            return Err(places.error("rbf.substeps", message));
        }
        Ok(())
    }
}

/// Method that selects base points.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Schedule, SelectionMethod, Steps};
///
/// // New base points every 30 degrees.
/// let schedule = Schedule::new(Steps::azimuth_deg(0.0, 360.0, 5.0))
///     .method(SelectionMethod::Real)
///     .refresh_deg(30.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SelectionMethod {
    /// Greedy, for all steps at once.
    Sequence,
    /// Greedy, once, for one displacement that all moving nodes share.
    Constant,
    /// Greedy, for the displacements of one step; repeated at every step or every few degrees.
    Real,
    /// Every surface node.
    All,
}

/// Error norm of the surface nodes that must meet the tolerance.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Schedule, SelectionCriterion, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0]))
///     .criterion(SelectionCriterion::Mean)
///     .tolerance(1e-4);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SelectionCriterion {
    /// The largest.
    #[default]
    Max,
    /// The mean.
    Mean,
}

/// An azimuth interval after which base points are selected again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refresh {
    /// In radians, greater than 0.
    pub azimuth: f64,
    /// In degrees.
    pub azimuth_deg: f64,
}

/// An angle in the unit of the schedule.
const REFRESH: Kind<Refresh> = Kind {
    words: "angle",
    read: |entry| {
        let (angle, unit) = (entry.positive()?, entry.unit());
        Ok(Refresh {
            azimuth: unit.to_radians(angle),
            azimuth_deg: unit.to_degrees(angle),
        })
    },
    schema: positive("").schema,
};

keys! {
    /// `[selection]`: the base points.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SelectionOptions "[selection]" {
        /// `"sequence"`: chosen greedily, once, for all steps; `"constant"`: once, for one displacement of all moving
        /// nodes (Algorithm 2 of the [paper](../validation/paper.md)), if the motion is not known beforehand; `"real"`:
        /// again at each step, for its displacements (Algorithm 1); `"all"`: every surface node (at most 40,000) that
        /// double precision can separate
        pub method: SelectionMethod, choice::<SelectionMethod>(), default "sequence";
        /// displacement error allowed on any surface node at any step, before the correction; greater than 0. Default:
        /// 1e-4 of the diagonal of the box around the moving tags; without correction the smallest first-cell height
        pub tolerance: Option<f64>, positive("length"), or "chosen and reported";
        /// which error must meet the tolerance: the largest of the surface nodes, or their mean
        pub criterion: SelectionCriterion, choice::<SelectionCriterion>(), default "max";
        /// with method `"constant"` only: the displacement, longer than the tolerance. Default: the largest
        /// displacement of a moving node at any step in x, in y and in z
        pub constant: Option<Vector>, numbers::<3>("3 lengths"), or "the motion's";
        /// largest number of base points; if they do not meet the tolerance, no mesh is written. Not used with `"all"`;
        /// with method `"constant"` reaching it is a normal end
        pub max_points: usize, count("integer"), default 5000;
        /// with method `"real"` only, greater than 0: base points are chosen again after this azimuth, counted from the
        /// first step of the schedule
        pub refresh: Option<Refresh>, REFRESH, or "every step";
        /// moving nodes are written exactly where the motion takes them, fixed ones at their position; sliding ones are
        /// always put on their boundary
        pub correction: bool, boolean(), default true;
    }
}

impl SelectionOptions {
    /// Refuses invalid numbers, and keys of another method.
    pub(super) fn check(&self, places: &Places) -> Result<()> {
        if let Some(tolerance) = self.tolerance {
            places.positive("selection.tolerance", tolerance)?;
        }
        places.positive("selection.max_points", self.max_points as f64)?;
        if let Some(constant) = self.constant {
            let key = "selection.constant";
            if self.method != SelectionMethod::Constant {
                return Err(places.error(
                    key,
                    "`constant` needs method = \"constant\"; set that, or leave the key out",
                ));
            }
            places.finite(key, &constant)?;
            if constant == [0.0; 3] {
                return Err(places.error(
                    key,
                    "`constant` is zero, so no base points would be chosen; give a displacement such as [0.0, \
                     0.0, 1.0], or leave the key out to use the displacement of the motion",
                ));
            }
        }
        if let Some(refresh) = self.refresh {
            let key = "selection.refresh";
            if self.method != SelectionMethod::Real {
                return Err(places.error(
                    key,
                    "`refresh` needs method = \"real\"; set that, or leave the key out",
                ));
            }
            places.positive(key, refresh.azimuth_deg)?;
        }
        Ok(())
    }
}

//! `[rbf]` and `[selection]`: options of the interpolation and of the base points.

use super::places::Places;
use super::reader::{AngleUnit, Entry};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::Vector;

const RBF: &[&str] = &[
    "kernel",
    "support_radius",
    "polynomial",
    "interpolate",
    "rotation_radius",
    "substeps",
];
const SELECTION: &[&str] = &[
    "method",
    "tolerance",
    "criterion",
    "constant",
    "max_points",
    "refresh",
    "correction",
];

/// Substeps a step may be cut into at most.
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
    const ALL: [(&str, Self); 4] = [
        ("wendland-c0", Self::WendlandC0),
        ("wendland-c2", Self::WendlandC2),
        ("wendland-c4", Self::WendlandC4),
        ("wendland-c6", Self::WendlandC6),
    ];

    /// The name as it stands in a schedule.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

/// What is added to the radial basis functions.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Polynomial, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0])).polynomial(Polynomial::Linear);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Polynomial {
    /// Nothing: the mesh is at rest where no base point reaches.
    #[default]
    None,
    /// `p0 + p1 x + p2 y + p3 z`, so that an affine motion is reproduced everywhere.
    Linear,
}

/// What is interpolated into the volume.
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

/// `[rbf]`: the interpolation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RbfOptions {
    /// Radial basis function.
    pub kernel: KernelName,
    /// Support radius in mesh units; chosen by the program when `None`.
    pub support_radius: Option<f64>,
    /// What is added to the radial basis functions.
    pub polynomial: Polynomial,
    /// What is interpolated.
    pub interpolate: Interpolate,
    /// Support radius of the rotation alone, in mesh units; that of everything else when `None`.
    /// Only with [`Interpolate::Twist`].
    pub rotation_radius: Option<f64>,
    /// Parts that each step is cut into, at least one.
    pub substeps: usize,
}

impl Default for RbfOptions {
    fn default() -> Self {
        Self {
            kernel: KernelName::default(),
            support_radius: None,
            polynomial: Polynomial::None,
            interpolate: Interpolate::Displacement,
            rotation_radius: None,
            substeps: 1,
        }
    }
}

impl RbfOptions {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[rbf]", RBF)?;
        let mut options = Self::default();
        section.set("kernel", &mut options.kernel, |entry| {
            entry.choice(&KernelName::ALL)
        })?;
        options.support_radius = section.optional("support_radius", Entry::positive)?;
        let known = [("none", Polynomial::None), ("linear", Polynomial::Linear)];
        section.set("polynomial", &mut options.polynomial, |entry| {
            entry.choice(&known)
        })?;
        let known = [
            ("displacement", Interpolate::Displacement),
            ("twist", Interpolate::Twist),
        ];
        section.set("interpolate", &mut options.interpolate, |entry| {
            entry.choice(&known)
        })?;
        options.rotation_radius = section.optional("rotation_radius", Entry::positive)?;
        section.set("substeps", &mut options.substeps, Entry::count)?;
        Ok(options)
    }

    /// Refuses numbers out of their range, and what does not go together.
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

/// How base points are chosen.
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
    /// Greedily, for all steps at once.
    Sequence,
    /// Greedily, once, for one displacement that all moving nodes share.
    Constant,
    /// Greedily, for the displacements of one step, anew at every step or every few degrees.
    Real,
    /// Every surface node.
    All,
}

/// Which error of the surface nodes is to meet the tolerance.
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

/// An azimuth interval after which base points are chosen anew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refresh {
    /// In radians, greater than 0.
    pub azimuth: f64,
    /// In degrees.
    pub azimuth_deg: f64,
}

/// `[selection]`: the base points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionOptions {
    /// How base points are chosen.
    pub method: SelectionMethod,
    /// Displacement error allowed on any surface node at any step, in mesh units; chosen by the
    /// program when `None`.
    pub tolerance: Option<f64>,
    /// Which error is to meet the tolerance.
    pub criterion: SelectionCriterion,
    /// The displacement of [`SelectionMethod::Constant`], in mesh units and not zero; that of the
    /// motion when `None`.
    pub constant: Option<Vector>,
    /// Base points at most.
    pub max_points: usize,
    /// After which azimuth [`SelectionMethod::Real`] chooses anew; at every step when `None`.
    pub refresh: Option<Refresh>,
    /// Whether surface nodes are put exactly where the motion takes them.
    pub correction: bool,
}

impl Default for SelectionOptions {
    fn default() -> Self {
        Self {
            method: SelectionMethod::Sequence,
            tolerance: None,
            criterion: SelectionCriterion::Max,
            constant: None,
            max_points: 5000,
            refresh: None,
            correction: true,
        }
    }
}

impl SelectionOptions {
    pub(super) fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let section = entry.section("[selection]", SELECTION)?;
        let mut options = Self::default();
        let known = [
            ("sequence", SelectionMethod::Sequence),
            ("constant", SelectionMethod::Constant),
            ("real", SelectionMethod::Real),
            ("all", SelectionMethod::All),
        ];
        section.set("method", &mut options.method, |entry| entry.choice(&known))?;
        options.tolerance = section.optional("tolerance", Entry::positive)?;
        let known = [
            ("max", SelectionCriterion::Max),
            ("mean", SelectionCriterion::Mean),
        ];
        section.set("criterion", &mut options.criterion, |entry| {
            entry.choice(&known)
        })?;
        options.constant = section.optional("constant", Entry::numbers)?;
        section.set("max_points", &mut options.max_points, Entry::count)?;
        let refresh = section.optional("refresh", Entry::positive)?;
        options.refresh = refresh.map(|angle| Refresh {
            azimuth: unit.to_radians(angle),
            azimuth_deg: unit.to_degrees(angle),
        });
        section.set("correction", &mut options.correction, Entry::boolean)?;
        Ok(options)
    }

    /// Refuses numbers out of their range, and keys that go with another method.
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
                     0.0, 1.0], or leave the key out to use that of the motion",
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

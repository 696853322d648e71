//! What the schedule says of the interpolation and of base points.

use super::reader::{AngleUnit, Entry, Keys, Section};
use crate::error::Result;
use crate::geometry::vector::Vector;

const RBF: Keys = Keys {
    known: &[
        "kernel",
        "support_radius",
        "polynomial",
        "interpolate",
        "rotation_radius",
        "substeps",
    ],
    later: &[],
};
const SELECTION: Keys = Keys {
    known: &[
        "method",
        "tolerance",
        "criterion",
        "constant",
        "max_points",
        "refresh",
        "correction",
    ],
    later: &[],
};

/// Substeps a step may be cut into at most.
const MAX_SUBSTEPS: usize = 1000;

/// Radial basis functions by name.
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Polynomial {
    /// Nothing: the mesh is at rest where no base point reaches.
    #[default]
    None,
    /// `p0 + p1 x + p2 y + p3 z`, so that an affine motion is reproduced everywhere.
    Linear,
}

/// What is interpolated into the volume.
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
        let section = entry.section("[rbf]", &RBF)?;
        let mut options = Self::default();
        if let Some(kernel) = section.get("kernel") {
            options.kernel = kernel.choice(&KernelName::ALL, &[])?;
        }
        if let Some(radius) = section.get("support_radius") {
            options.support_radius = Some(radius.positive()?);
        }
        if let Some(polynomial) = section.get("polynomial") {
            let known = [("none", Polynomial::None), ("linear", Polynomial::Linear)];
            options.polynomial = polynomial.choice(&known, &[])?;
        }
        if let Some(interpolate) = section.get("interpolate") {
            let known = [
                ("displacement", Interpolate::Displacement),
                ("twist", Interpolate::Twist),
            ];
            options.interpolate = interpolate.choice(&known, &[])?;
        }
        if let Some(radius) = section.get("rotation_radius") {
            if options.interpolate != Interpolate::Twist {
                return Err(
                    radius.error("needs interpolate = \"twist\"; set that, or leave the key out")
                );
            }
            options.rotation_radius = Some(radius.positive()?);
        }
        if let Some(substeps) = section.get("substeps") {
            options.substeps = substeps.count()?;
            if options.substeps > MAX_SUBSTEPS {
                let n = options.substeps;
                return Err(substeps.error(&format!("is {n}; at most {MAX_SUBSTEPS} are possible")));
            }
        }
        Ok(options)
    }
}

/// How base points are chosen.
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
        let section = entry.section("[selection]", &SELECTION)?;
        let mut options = Self::default();
        if let Some(method) = section.get("method") {
            let known = [
                ("sequence", SelectionMethod::Sequence),
                ("constant", SelectionMethod::Constant),
                ("real", SelectionMethod::Real),
                ("all", SelectionMethod::All),
            ];
            options.method = method.choice(&known, &[])?;
        }
        if let Some(tolerance) = section.get("tolerance") {
            options.tolerance = Some(tolerance.positive()?);
        }
        if let Some(criterion) = section.get("criterion") {
            let known = [
                ("max", SelectionCriterion::Max),
                ("mean", SelectionCriterion::Mean),
            ];
            options.criterion = criterion.choice(&known, &[])?;
        }
        options.constant = read_constant(&section, options.method)?;
        if let Some(max_points) = section.get("max_points") {
            options.max_points = max_points.count()?;
        }
        options.refresh = read_refresh(&section, options.method, unit)?;
        if let Some(correction) = section.get("correction") {
            options.correction = correction.boolean()?;
        }
        Ok(options)
    }
}

fn read_constant(section: &Section<'_>, method: SelectionMethod) -> Result<Option<Vector>> {
    let Some(entry) = section.get("constant") else {
        return Ok(None);
    };
    if method != SelectionMethod::Constant {
        return Err(entry.error("needs method = \"constant\"; set that, or leave the key out"));
    }
    let constant: Vector = entry.numbers()?;
    if constant == [0.0; 3] {
        return Err(entry.error(
            "is zero, which every choice of base points reproduces; give a displacement such as \
             [0.0, 0.0, 1.0], or leave the key out for that of the motion",
        ));
    }
    Ok(Some(constant))
}

fn read_refresh(
    section: &Section<'_>,
    method: SelectionMethod,
    unit: AngleUnit,
) -> Result<Option<Refresh>> {
    let Some(entry) = section.get("refresh") else {
        return Ok(None);
    };
    if method != SelectionMethod::Real {
        return Err(entry.error("needs method = \"real\"; set that, or leave the key out"));
    }
    let angle = entry.positive()?;
    Ok(Some(Refresh {
        azimuth: unit.to_radians(angle),
        azimuth_deg: unit.to_degrees(angle),
    }))
}

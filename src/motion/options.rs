//! What the schedule says of boundaries, interpolation, base points and output.

use super::body::patterns;
use super::names::Pattern;
use super::reader::{Entry, Keys, NOT_YET};
use crate::error::Result;
use crate::formats::{self, Compression, Encoding, Precision};

const BOUNDARIES: Keys = Keys {
    known: &["zones", "fixed", "others"],
    later: &[("slide", NOT_YET), ("periodic", NOT_YET)],
};
const RBF: Keys = Keys {
    known: &[
        "kernel",
        "support_radius",
        "polynomial",
        "interpolate",
        "substeps",
    ],
    later: &[("rotation_radius", NOT_YET)],
};
const SELECTION: Keys = Keys {
    known: &[
        "method",
        "tolerance",
        "criterion",
        "max_points",
        "correction",
    ],
    later: &[("constant", NOT_YET), ("refresh", NOT_YET)],
};
const OUTPUT: Keys = Keys {
    known: &[
        "format",
        "precision",
        "quality",
        "displacement",
        "velocity",
        "encoding",
        "compression",
        "on_inverted",
    ],
    later: &[],
};

/// What becomes of boundary tags that are not named anywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Others {
    /// They stay where they are.
    Fixed,
    /// They follow the interpolation like the inside of the mesh.
    Free,
}

/// `[boundaries]`: which zones deform and what the boundaries that belong to no body do.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Boundaries {
    /// Zones that deform; all when empty.
    pub zones: Vec<Pattern>,
    /// Tags that stay where they are.
    pub fixed: Vec<Pattern>,
    /// Tags not named anywhere; an error when left out and there are any.
    pub others: Option<Others>,
    pub(super) line: Option<u64>,
}

impl Boundaries {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[boundaries]", &BOUNDARIES)?;
        let names = |key: &str, what: &str| {
            let entry = section.get(key);
            entry.map_or(Ok(Vec::new()), |entry| patterns(&entry, what))
        };
        let known = [("fixed", Others::Fixed), ("free", Others::Free)];
        let others = section.get("others");
        Ok(Self {
            zones: names("zones", "zones")?,
            fixed: names("fixed", "tags")?,
            others: others
                .map(|entry| entry.choice(&known, &["slide"]))
                .transpose()?,
            line: Some(section.line),
        })
    }
}

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

/// `[rbf]`: the interpolation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RbfOptions {
    /// Radial basis function.
    pub kernel: KernelName,
    /// Support radius in mesh units; chosen by the program when `None`.
    pub support_radius: Option<f64>,
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
            polynomial.choice(&[("none", ())], &["linear"])?;
        }
        if let Some(interpolate) = section.get("interpolate") {
            interpolate.choice(&[("displacement", ())], &["twist"])?;
        }
        if let Some(substeps) = section.get("substeps") {
            let n = substeps.count()?;
            if n != 1 {
                return Err(substeps.error(&format!("= {n} {NOT_YET}; available: 1")));
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
    /// Every surface node.
    All,
}

/// `[selection]`: the base points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionOptions {
    /// How base points are chosen.
    pub method: SelectionMethod,
    /// Displacement error allowed on any surface node at any step, in mesh units; chosen by the
    /// program when `None`.
    pub tolerance: Option<f64>,
    /// Base points at most.
    pub max_points: usize,
    /// Whether surface nodes are put exactly where the motion takes them.
    pub correction: bool,
}

impl Default for SelectionOptions {
    fn default() -> Self {
        Self {
            method: SelectionMethod::Sequence,
            tolerance: None,
            max_points: 5000,
            correction: true,
        }
    }
}

impl SelectionOptions {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[selection]", &SELECTION)?;
        let mut options = Self::default();
        if let Some(method) = section.get("method") {
            let known = [
                ("sequence", SelectionMethod::Sequence),
                ("all", SelectionMethod::All),
            ];
            options.method = method.choice(&known, &["constant", "real"])?;
        }
        if let Some(tolerance) = section.get("tolerance") {
            options.tolerance = Some(tolerance.positive()?);
        }
        if let Some(criterion) = section.get("criterion") {
            criterion.choice(&[("max", ())], &["mean"])?;
        }
        if let Some(max_points) = section.get("max_points") {
            options.max_points = max_points.count()?;
        }
        if let Some(correction) = section.get("correction") {
            options.correction = correction.boolean()?;
        }
        Ok(options)
    }
}

/// How much quality is worked out at each step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QualityOutput {
    /// A row of steps.csv.
    Summary,
    /// The row, and cell arrays in the mesh.
    Cells,
    /// Nothing.
    None,
}

/// What happens when a step has inverted cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnInverted {
    /// Warn and go on; the exit code is 1.
    Warn,
    /// Stop there.
    Stop,
}

/// `[output]`: what is written.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputOptions {
    /// Name of a writable format.
    pub format: String,
    /// Precision of coordinates.
    pub precision: Precision,
    /// How much quality is worked out.
    pub quality: QualityOutput,
    /// Whether the displacement is added as a point array.
    pub displacement: bool,
    /// How numbers are stored.
    pub encoding: Encoding,
    /// Compression of binary data.
    pub compression: Compression,
    /// What happens when a step has inverted cells.
    pub on_inverted: OnInverted,
}

impl Default for OutputOptions {
    fn default() -> Self {
        Self {
            format: "vtu".into(),
            precision: Precision::F64,
            quality: QualityOutput::Summary,
            displacement: false,
            encoding: Encoding::Raw,
            compression: Compression::None,
            on_inverted: OnInverted::Warn,
        }
    }
}

impl OutputOptions {
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[output]", &OUTPUT)?;
        let mut options = Self::default();
        if let Some(format) = section.get("format") {
            let known: Vec<(&str, &str)> = formats::FORMATS
                .iter()
                .map(|format| (format.name(), format.name()))
                .collect();
            options.format = format.choice(&known, &["vtkhdf", "cgns"])?.to_owned();
        }
        if let Some(precision) = section.get("precision") {
            let known = [("f64", Precision::F64), ("f32", Precision::F32)];
            options.precision = precision.choice(&known, &[])?;
        }
        if let Some(quality) = section.get("quality") {
            let known = [
                ("summary", QualityOutput::Summary),
                ("cells", QualityOutput::Cells),
                ("none", QualityOutput::None),
            ];
            options.quality = quality.choice(&known, &[])?;
        }
        if let Some(displacement) = section.get("displacement") {
            options.displacement = displacement.boolean()?;
        }
        if let Some(velocity) = section.get("velocity")
            && velocity.boolean()?
        {
            return Err(velocity.error(&format!("= true {NOT_YET}; available: false")));
        }
        if let Some(encoding) = section.get("encoding") {
            let known = [
                ("raw", Encoding::Raw),
                ("base64", Encoding::Base64),
                ("ascii", Encoding::Ascii),
            ];
            options.encoding = encoding.choice(&known, &[])?;
        }
        if let Some(compression) = section.get("compression") {
            let known = [
                ("none", Compression::None),
                ("zlib", Compression::Zlib),
                ("lz4", Compression::Lz4),
                ("lzma", Compression::Lzma),
            ];
            options.compression = compression.choice(&known, &[])?;
        }
        if let Some(on_inverted) = section.get("on_inverted") {
            let known = [("warn", OnInverted::Warn), ("stop", OnInverted::Stop)];
            options.on_inverted = on_inverted.choice(&known, &["substeps"])?;
        }
        Ok(options)
    }
}

//! What the schedule says of the files that are written.

use super::reader::{Entry, Keys};
use crate::error::Result;
use crate::formats::{self, Compression, Encoding, Precision, WriteOptions};

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
    /// Take the step again in 2, 4, 8 substeps; warn where that does not help.
    Substeps,
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
    /// Whether node velocities are added as a point array.
    pub velocity: bool,
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
            velocity: false,
            encoding: Encoding::Raw,
            compression: Compression::None,
            on_inverted: OnInverted::Warn,
        }
    }
}

impl OutputOptions {
    /// How meshes are written.
    pub fn write_options(&self) -> WriteOptions {
        WriteOptions {
            encoding: self.encoding,
            compression: self.compression,
            precision: self.precision,
            tag_names: true,
            pieces: None,
        }
    }

    /// Whether coordinates are written in 32 bits.
    pub fn rounds(&self) -> Result<bool> {
        Ok(formats::by_name(&self.format)?.rounds(self.precision))
    }

    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[output]", &OUTPUT)?;
        let mut options = Self::default();
        if let Some(format) = section.get("format") {
            let known: Vec<(&str, &str)> = formats::with_flavours()
                .map(|format| (format.name(), format.name()))
                .collect();
            options.format = format.choice(&known, &[])?.to_owned();
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
        if let Some(velocity) = section.get("velocity") {
            options.velocity = velocity.boolean()?;
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
            let known = [
                ("warn", OnInverted::Warn),
                ("stop", OnInverted::Stop),
                ("substeps", OnInverted::Substeps),
            ];
            options.on_inverted = on_inverted.choice(&known, &[])?;
        }
        Ok(options)
    }
}

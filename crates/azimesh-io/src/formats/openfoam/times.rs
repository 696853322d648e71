//! The folders of times and their files. Folders are named as OpenFOAM writes numbers: in `timeFormat`, with `timePrecision`
//! digits or as many more as give the time back. They have the points, and the displacement of the points that solvers interpolate between times.

use super::boundary::patches_of;
use super::case::CONSTANT;
use super::file::entry_of;
use super::output::{CaseFiles, vectors};
use super::sequence::DISPLACEMENT;
use super::topology::Topology;
use crate::formats::Notes;
use crate::formats::records::write_all;
use crate::mesh::{MeshView, Values};
use azimesh_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// Name of the field that OpenFOAM's mover `interpolator` reads.
pub(super) const WANTED: &str = "wantedDisplacement";

/// Types of patches that fields at points have under the same name; on other patches they are `calculated`.
const CONSTRAINTS: &str = "empty wedge symmetry symmetryPlane cyclic cyclicSlip cyclicAMI cyclicACMI nonConformalCyclic \
     nonConformalError nonConformalProcessorCyclic nonuniformTransformCyclic processor processorCyclic";

/// Format of the names of times: digits behind the point or, of general ones, significant digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TimeNames {
    General(usize),
    Fixed(usize),
    Scientific(usize),
}

impl Default for TimeNames {
    fn default() -> Self {
        Self::General(6)
    }
}

impl TimeNames {
    /// From the case that is written or, before it has a file `controlDict`, from the case of the mesh.
    pub fn of(case: &Path, mesh: &MeshView) -> Result<Self> {
        let origin = mesh.origin.get::<Topology>();
        match origin.filter(|_| !case.join("system").join("controlDict").is_file()) {
            Some(origin) => Self::of_case(&origin.path.root),
            None => Self::of_case(case),
        }
    }

    /// As the file `controlDict` of a case says; the usual ones where there is none.
    pub fn of_case(case: &Path) -> Result<Self> {
        let path = case.join("system").join("controlDict");
        if !path.is_file() {
            return Ok(Self::default());
        }
        let bytes = std::fs::read(&path).map_err(|error| Error::io(&path, &error))?;
        Self::of_dictionary(&bytes).map_err(|error| Error::input(error).file(&path))
    }

    fn of_dictionary(bytes: &[u8]) -> std::result::Result<Self, String> {
        let precision = match entry_of(bytes, "timePrecision") {
            None => 6,
            Some(text) => {
                let number = text.parse().ok().filter(|n| (1..=100).contains(n));
                number.ok_or_else(|| {
                    format!("timePrecision is \"{text}\"; it must be a number from 1 to 100")
                })?
            }
        };
        match entry_of(bytes, "timeFormat").as_deref() {
            None | Some("general") => Ok(Self::General(precision)),
            Some("fixed") => Ok(Self::Fixed(precision)),
            Some("scientific") => Ok(Self::Scientific(precision)),
            Some(text) => Err(format!(
                "timeFormat is \"{text}\"; it must be general, fixed or scientific"
            )),
        }
    }

    /// The name of a time, with as many digits as give the time back to 1e-12 of itself.
    pub fn name(&self, time: f64) -> String {
        const ROUNDED: f64 = 1e-12;
        let is_same = |name: &String| {
            let read: f64 = name.parse().unwrap_or(f64::NAN);
            (read - time).abs() <= ROUNDED * time.abs()
        };
        let mut names = (0..17).map(|more| self.with_more_digits(more).rounded(time));
        let name = names.find(is_same);
        name.unwrap_or_else(|| self.rounded(time))
    }

    fn with_more_digits(self, more: usize) -> Self {
        match self {
            Self::General(digits) => Self::General(digits + more),
            Self::Fixed(digits) => Self::Fixed(digits + more),
            Self::Scientific(digits) => Self::Scientific(digits + more),
        }
    }

    /// The name of a time in these digits: of general ones, as `%g` of C writes it.
    fn rounded(&self, time: f64) -> String {
        // Zero has no sign.
        let time = time + 0.0;
        let digits = match *self {
            Self::Fixed(precision) => return format!("{time:.precision$}"),
            Self::Scientific(precision) => return scientific(time, precision),
            Self::General(digits) => digits,
        };
        let text = scientific(time, digits - 1);
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let power: i32 = exponent.parse().unwrap_or(0);
        if power < -4 || power >= digits as i32 {
            return format!("{}e{exponent}", without_zeros(mantissa));
        }
        let behind = (digits as i32 - 1 - power).max(0) as usize;
        without_zeros(&format!("{time:.behind$}")).to_owned()
    }

    /// The folder of each step: its time, and [`CONSTANT`] for a first step at time 0.
    pub fn folders(&self, times: &[f64]) -> Result<Vec<String>> {
        let mut known = BTreeMap::new();
        let folders = times.iter().map(|time| self.new_folder(*time, &mut known));
        folders.collect()
    }

    /// The folder of the next step, which is added to those `known`, with their times.
    pub fn new_folder(&self, time: f64, known: &mut BTreeMap<String, f64>) -> Result<String> {
        let name = self.name(time);
        // A later step at time 0 would be a second mesh of that time.
        if let Some(other) = known.insert(name.clone(), time) {
            return Err(Error::input(format!(
                "two steps are at the times {other} and {time}, which would have one folder, {name}; give steps of other times"
            )));
        }
        Ok(match known.len() == 1 && time == 0.0 {
            true => CONSTANT.to_owned(),
            false => name,
        })
    }
}

/// As `%e` of C writes it: at least two digits of the exponent.
fn scientific(time: f64, precision: usize) -> String {
    let text = format!("{time:.precision$e}");
    let Some((mantissa, exponent)) = text.split_once('e') else {
        return text;
    };
    let (sign, digits) = match exponent.strip_prefix('-') {
        Some(digits) => ('-', digits),
        None => ('+', exponent),
    };
    format!("{mantissa}e{sign}{digits:0>2}")
}

fn without_zeros(text: &str) -> &str {
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.')
}

/// Writes the points of a time and, where the mesh has it as an array, the displacement.
pub(super) fn write_time(
    files: &mut CaseFiles,
    mesh: &MeshView,
    folder: &str,
    field_folder: &str,
) -> Result<()> {
    files.out.place_in(&files.place.path.root, &[])?;
    files.points(mesh.points, folder)?;
    let mut arrays = mesh.point_arrays.iter();
    let displacement = arrays.find(|array| array.name == DISPLACEMENT && array.n_components == 3);
    let Some(Values::F64(values)) = displacement.map(|array| &array.values) else {
        return Ok(());
    };
    let mut of_whole = patches_of(mesh, mesh.origin.get::<Topology>(), &mut Notes::default())?;
    if let Some(rest) = of_whole.last_mut() {
        // A pattern for faces of no tag, which may not be there.
        rest.name = format!("\"{}.*\"", rest.name);
    }
    let path = format!("{}/{WANTED}", files.place.path.fields(field_folder));
    let is_binary = files.is_binary;
    files.write(&path, "pointVectorField", "", &|out, piece| {
        let before =
            "dimensions      [0 1 0 0 0 0 0];\n\ninternalField   nonuniform List<vector> \n";
        write_all(out, before.as_bytes())?;
        vectors(out, values.as_chunks().0, piece, is_binary)?;
        write_all(out, b";\n\nboundaryField\n{\n")?;
        for patch in piece.map_or(&of_whole, |piece| &piece.patches) {
            let mut known = CONSTRAINTS.split(' ');
            let of_field = known.find(|known| *known == patch.kind);
            let (name, of_field) = (&patch.name, of_field.unwrap_or("calculated"));
            let entry =
                format!("    {name}\n    {{\n        type            {of_field};\n    }}\n");
            write_all(out, entry.as_bytes())?;
        }
        write_all(out, b"}\n")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_says;

    #[test]
    fn times_are_named_as_openfoam_does() {
        let names = TimeNames::default();
        for (time, name) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.1, "0.1"),
            (1.0 / 3.0, "0.333333333333"),
            (10.0 + 1.0 / 360.0, "10.00277777778"),
            (360.0, "360"),
            (123_456.0, "123456"),
            (1_234_567.0, "1234567"),
            (1.25e7, "1.25e+07"),
            (1e-5, "1e-05"),
            (0.000_123_456_7, "0.0001234567"),
            (-2.5, "-2.5"),
            (999_999.9, "999999.9"),
            (1e100, "1e+100"),
        ] {
            assert_eq!(names.name(time), name);
        }
        let of = |text: &str| TimeNames::of_dictionary(text.as_bytes()).expect("it is good");
        let fixed = of("timeFormat fixed;\ntimePrecision 3; // digits\n");
        assert_eq!(
            (&*fixed.name(0.5), &*fixed.name(0.0625)),
            ("0.500", "0.0625")
        );
        let scientific = of("timeFormat scientific;\n");
        assert_eq!(scientific.name(1234.5), "1.234500e+03");
        let text = "FoamFile { timePrecision 2; }\n/* timePrecision 3; */ timePrecision 9;\nfunctions { a { timePrecision 4; } }";
        assert_eq!(of(text), TimeNames::General(9));
        assert_eq!(of("application x;"), TimeNames::default());
        assert!(TimeNames::of_dictionary(b"timePrecision many;").is_err());
    }

    #[test]
    fn two_steps_of_one_name_are_refused() {
        let names = TimeNames::default();
        let folders = names.folders(&[0.0, 0.1, 0.2]).expect("all differ");
        assert_eq!(folders, ["constant", "0.1", "0.2"]);
        assert_eq!(
            names.folders(&[-1.0, 0.0]).expect("they differ"),
            ["-1", "0"]
        );
        for times in [
            &[0.0, 1.0, 1.000_000_000_000_1][..],
            &[0.0, 1.0, 0.0],
            &[0.0, 1e-9, -0.0],
        ] {
            let error = names.folders(times).expect_err("two are alike");
            assert_says(&error.message, "one folder");
        }
    }
}

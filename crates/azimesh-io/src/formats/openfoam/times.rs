//! Names of the folders of times, as OpenFOAM writes numbers: with `timePrecision` digits, in `timeFormat`.

use super::dictionary::entry_of;
use super::folders::CONSTANT;
use azimesh_core::error::{Error, Result};
use std::path::Path;

/// How OpenFOAM writes a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeNames {
    /// Significant digits, or digits behind the point where the format is not `general`.
    precision: usize,
    format: TimeFormat,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum TimeFormat {
    General,
    Fixed,
    Scientific,
}

impl Default for TimeNames {
    fn default() -> Self {
        Self {
            precision: 6,
            format: TimeFormat::General,
        }
    }
}

impl TimeNames {
    /// As the file `controlDict` of a case says; the usual ones where there is none.
    pub fn of_case(case: &Path) -> Result<Self> {
        let path = case.join("system").join("controlDict");
        if !path.is_file() {
            return Ok(Self::default());
        }
        let bytes = std::fs::read(&path).map_err(|error| Error::io(&path, &error))?;
        Self::of_dictionary(&bytes).map_err(|error| error.file(&path))
    }

    fn of_dictionary(bytes: &[u8]) -> Result<Self> {
        let mut names = Self::default();
        if let Some(text) = entry_of(bytes, "timePrecision") {
            let number = text.parse().ok().filter(|n| (1..=100).contains(n));
            names.precision = number.ok_or_else(|| {
                Error::input(format!(
                    "timePrecision is \"{text}\"; it must be a number from 1 to 100"
                ))
            })?;
        }
        if let Some(text) = entry_of(bytes, "timeFormat") {
            names.format = match text.as_str() {
                "general" => TimeFormat::General,
                "fixed" => TimeFormat::Fixed,
                "scientific" => TimeFormat::Scientific,
                _ => {
                    return Err(Error::input(format!(
                        "timeFormat is \"{text}\"; it must be general, fixed or scientific"
                    )));
                }
            };
        }
        Ok(names)
    }

    /// The name of a time.
    pub fn name(&self, time: f64) -> String {
        // Zero has no sign.
        let time = time + 0.0;
        match self.format {
            TimeFormat::Fixed => format!("{time:.*}", self.precision),
            TimeFormat::Scientific => scientific(time, self.precision),
            TimeFormat::General => self.general(time),
        }
    }

    /// As `%g` of C writes it.
    fn general(&self, time: f64) -> String {
        let digits = self.precision.max(1);
        let text = format!("{time:.*e}", digits - 1);
        let exponent = text
            .split_once('e')
            .and_then(|(_, exponent)| exponent.parse::<i32>().ok());
        let exponent = exponent.unwrap_or(0);
        if exponent < -4 || exponent >= digits as i32 {
            let text = scientific(time, digits - 1);
            return match text.split_once('e') {
                Some((mantissa, exponent)) => format!("{}e{exponent}", without_zeros(mantissa)),
                None => text,
            };
        }
        let behind = (digits as i32 - 1 - exponent).max(0) as usize;
        without_zeros(&format!("{time:.behind$}")).to_owned()
    }

    /// The folder of each step: that of its time, and [`CONSTANT`] of a first one at time 0.
    pub fn folders(&self, times: &[f64]) -> Result<Vec<String>> {
        let name = |(step, time): (usize, &f64)| match step == 0 && *time == 0.0 {
            true => CONSTANT.to_owned(),
            false => self.name(*time),
        };
        let names: Vec<String> = times.iter().enumerate().map(name).collect();
        let mut order: Vec<usize> = (0..names.len()).collect();
        order.sort_by_key(|step| (&names[*step], *step));
        // A later step at time 0 would be a second mesh of that time.
        let zero = self.name(0.0);
        let zeros = (0..names.len()).filter(|&step| names[step] == zero || names[step] == CONSTANT);
        let zeros: Vec<usize> = zeros.collect();
        let same = order.windows(2).find(|two| names[two[0]] == names[two[1]]);
        let same = same.map(|two| (two[0], two[1]));
        match same.or(zeros.get(1).map(|second| (zeros[0], *second))) {
            None => Ok(names),
            Some((a, b)) => Err(Error::input(format!(
                "steps {a} and {b} are at the times {} and {}, which would have one folder, {}; raise timePrecision in \
                 system/controlDict, which is {}, or give steps of other times",
                times[a],
                times[b],
                self.name(times[b]),
                self.precision
            ))),
        }
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
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_named_as_openfoam_does() {
        let names = TimeNames::default();
        for (time, name) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.1, "0.1"),
            (1.0 / 3.0, "0.333333"),
            (360.0, "360"),
            (123_456.0, "123456"),
            (1_234_567.0, "1.23457e+06"),
            (1e-5, "1e-05"),
            (0.000_123_456_7, "0.000123457"),
            (-2.5, "-2.5"),
            (999_999.9, "1e+06"),
            (1e100, "1e+100"),
        ] {
            assert_eq!(names.name(time), name);
        }
        let of = |text: &str| TimeNames::of_dictionary(text.as_bytes()).expect("it is good");
        let fixed = of("timeFormat fixed;\ntimePrecision 3; // digits\n");
        assert_eq!(fixed.name(0.5), "0.500");
        let scientific = of("timeFormat scientific;\n");
        assert_eq!(scientific.name(1234.5), "1.234500e+03");
        let text = "FoamFile { timePrecision 2; }\n/* timePrecision 3; */ timePrecision 9;\nfunctions { a { timePrecision 4; } }";
        assert_eq!(of(text).precision, 9);
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
            &[0.0, 1.0, 1.000_000_1][..],
            &[0.0, 1.0, 0.0],
            &[0.0, 1e-9, -0.0],
        ] {
            let error = names.folders(times).expect_err("two are alike");
            assert!(error.message.contains("timePrecision"), "{error}");
        }
    }
}

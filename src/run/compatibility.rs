//! In what two runs differ that decides what they write, by their records.

use crate::record::{FunctionRecord, RunRecord};
use serde_json::Value;

/// The first difference of two runs.
#[derive(Debug, PartialEq)]
pub(super) enum Difference {
    /// The program or its version: of one run and the other.
    Program(String, String),
    /// The kinds of input files, or their number.
    Inputs,
    /// An input came from standard input or another pipe, of which there is no hash.
    NoHash,
    /// The content of an input file: what it is, and its names in one run and the other.
    Content(String, String, String),
    /// A function without a name moves this body: whether it is the same one cannot be known.
    NoName(String),
    /// Functions of other bodies, or with other names: of one run and the other.
    Functions(String, String),
    /// An option: its name and values.
    Option(String, Value, Value),
}

/// In what two runs differ; `None` where they write the same.
pub(super) fn difference(one: &RunRecord, other: &RunRecord) -> Option<Difference> {
    if one.program != other.program {
        let [one, other] = [one, other].map(|record| match record.program.as_str() {
            "" => "an unknown version".to_owned(),
            program => program.to_owned(),
        });
        return Some(Difference::Program(one, other));
    }
    for (input, other) in one.inputs.iter().zip(&other.inputs) {
        if input.what != other.what {
            return Some(Difference::Inputs);
        }
        if input.blake3.is_none() || other.blake3.is_none() {
            return Some(Difference::NoHash);
        }
        if input.blake3 != other.blake3 {
            let [what, one, other] = [&input.what, &input.file, &other.file].map(String::clone);
            return Some(Difference::Content(what, one, other));
        }
    }
    if one.inputs.len() != other.inputs.len() {
        return Some(Difference::Inputs);
    }
    let mut functions = one.functions.iter().chain(&other.functions);
    if let Some(unnamed) = functions.find(|function| function.name.is_none()) {
        return Some(Difference::NoName(unnamed.body.clone()));
    }
    if one.functions != other.functions {
        let [one, other] = [one, other].map(|record| listed(&record.functions));
        return Some(Difference::Functions(one, other));
    }
    let options = one.options.entries().into_iter();
    let mut pairs = options.zip(other.options.entries());
    let ((name, value), (_, other)) = pairs.find(|((_, value), (_, other))| value != other)?;
    Some(Difference::Option(name, value, other))
}

/// Functions by their names and bodies.
fn listed(functions: &[FunctionRecord]) -> String {
    let named = |function: &FunctionRecord| {
        let name = function.name.as_deref().unwrap_or_default();
        format!("\"{name}\" of body \"{}\"", function.body)
    };
    match functions {
        [] => "none".to_owned(),
        _ => functions
            .iter()
            .map(named)
            .collect::<Vec<_>>()
            .join(" and "),
    }
}

impl Difference {
    /// Of this run and an earlier one, as a sentence on the latter.
    pub fn since(&self) -> String {
        match self {
            Self::Program(now, then) => {
                format!("it was written by {then}; this is {now}, which may write other bytes")
            }
            Self::Content(what, now, then) if now == then => {
                format!("its {what} {now} has changed since")
            }
            Self::Content(what, now, then) => {
                format!("its {what} was {then}, with other content than {now}")
            }
            Self::Functions(now, then) => {
                format!("its functions were {then}; now they are {now}")
            }
            Self::Option(name, now, then) => format!("its {name} was {then}; now it is {now}"),
            Self::Inputs | Self::NoHash | Self::NoName(_) => self.of_inputs(),
        }
    }

    /// Of the first part of a sequence and another, as a sentence on the latter.
    pub fn beside(&self) -> String {
        match self {
            Self::Program(first, own) => {
                format!("it was written by {own}, the first part by {first}")
            }
            Self::Content(what, first, own) if first == own => {
                format!("its {what} {own} had other content")
            }
            Self::Content(what, first, own) => {
                format!("its {what} was {own}, that of the first part {first}, with other content")
            }
            Self::Functions(first, own) => {
                format!("its functions were {own}, those of the first part {first}")
            }
            Self::Option(name, first, own) => {
                format!("its {name} was {own}, that of the first part {first}")
            }
            Self::Inputs | Self::NoHash | Self::NoName(_) => self.of_inputs(),
        }
    }

    fn of_inputs(&self) -> String {
        match self {
            Self::NoHash => {
                "its mesh or schedule came from a pipe, so there is no hash to compare".to_owned()
            }
            Self::NoName(body) => format!(
                "body \"{body}\" is moved by a function without a name, which cannot be compared; \
                 give it one with `displacements_named`"
            ),
            _ => "it had more or fewer input files (base points of --base count as one)".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{InputRecord, OptionsRecord};

    #[test]
    fn a_difference_is_told_with_both_names() {
        let of = |schedule: &str, hash: &str, format: &str| {
            let file = |what: &str, file: &str, hash: &str| InputRecord {
                what: what.to_owned(),
                file: file.to_owned(),
                blake3: Some(hash.to_owned()),
            };
            RunRecord {
                program: "azimesh 1".to_owned(),
                inputs: vec![file("mesh", "n.vtu", "0"), file("schedule", schedule, hash)],
                options: OptionsRecord {
                    format: Some(format.to_owned()),
                    ..OptionsRecord::default()
                },
                ..RunRecord::default()
            }
        };
        let one = of("n.toml", "1", "vtu");
        let found = |other: &RunRecord| {
            let difference = difference(&one, other).expect("they differ");
            (difference.since(), difference.beside())
        };
        assert_eq!(difference(&one, &of("moved/n.toml", "1", "vtu")), None);
        let (since, beside) = found(&of("n.toml", "2", "vtu"));
        assert_eq!(since, "its schedule n.toml has changed since");
        assert_eq!(beside, "its schedule n.toml had other content");
        let (since, beside) = found(&of("n9.toml", "2", "vtu"));
        assert_eq!(
            since,
            "its schedule was n9.toml, with other content than n.toml"
        );
        assert_eq!(
            beside,
            "its schedule was n9.toml, that of the first part n.toml, with other content"
        );
        let (since, beside) = found(&of("n.toml", "1", "su2"));
        assert_eq!(since, "its format was \"su2\"; now it is \"vtu\"");
        assert_eq!(
            beside,
            "its format was \"su2\", that of the first part \"vtu\""
        );
    }
}

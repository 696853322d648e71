//! Differences of two runs that change their output, by their records.

use crate::record::{FunctionRecord, RunRecord};

/// Two runs that are compared.
#[derive(Debug, Clone, Copy)]
pub(super) enum Pair {
    /// This run and an earlier one in its folder.
    Resumed,
    /// The first part of a sequence and another one.
    Parts,
}

/// Returns the first difference of two runs, as a sentence on `other`; `None` if they write the same.
pub(super) fn difference(pair: Pair, one: &RunRecord, other: &RunRecord) -> Option<String> {
    let say = |resumed: String, of_parts: String| match pair {
        Pair::Resumed => Some(resumed),
        Pair::Parts => Some(of_parts),
    };
    if one.program != other.program {
        let [one, other] = [one, other].map(|record| match record.program.as_str() {
            "" => "an unknown version",
            program => program,
        });
        return say(
            format!("it was written by {other}; this is {one}, which may write other bytes"),
            format!("it was written by {other}, the first part by {one}"),
        );
    }
    const OTHER_INPUTS: &str =
        "it had more or fewer input files (base points of --base count as one)";
    for (input, own) in one.inputs.iter().zip(&other.inputs) {
        let (what, first, file) = (&own.what, &input.file, &own.file);
        if input.what != *what {
            return Some(OTHER_INPUTS.to_owned());
        }
        if input.blake3.is_none() || own.blake3.is_none() {
            let reason = "its mesh or schedule came from a pipe, so there is no hash to compare";
            return Some(reason.to_owned());
        }
        if matches!(pair, Pair::Resumed)
            && input.but_steps.is_some()
            && input.but_steps == own.but_steps
        {
            // Its steps are compared with those that are finished.
            continue;
        }
        if input.blake3 != own.blake3 && first == file {
            return say(
                format!("its {what} {file} has changed since"),
                format!("its {what} {file} had other content"),
            );
        }
        if input.blake3 != own.blake3 {
            return say(
                format!("its {what} was {file}, with other content than {first}"),
                format!("its {what} was {file}; the first part had {first}, with other content"),
            );
        }
    }
    if one.inputs.len() != other.inputs.len() {
        return Some(OTHER_INPUTS.to_owned());
    }
    let mut functions = one.functions.iter().chain(&other.functions);
    if let Some(unnamed) = functions.find(|function| function.name.is_none()) {
        return Some(format!(
            "body \"{}\" is moved by a function without a name, which cannot be compared; \
             give it one with `displacements_named`",
            unnamed.body
        ));
    }
    if one.functions != other.functions {
        let [one, other] = [one, other].map(|record| listed(&record.functions));
        return say(
            format!("its functions were {other}; now they are {one}"),
            format!("its functions were {other}; the first part had {one}"),
        );
    }
    let options = one.options.entries().into_iter();
    let mut pairs = options.zip(other.options.entries());
    let ((name, one), (_, other)) = pairs.find(|((_, one), (_, other))| one != other)?;
    say(
        format!("its {name} was {other}; now it is {one}"),
        format!("its {name} was {other}; the first part had {one}"),
    )
}

/// Lists functions by their names and bodies.
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
                but_steps: None,
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
            [Pair::Resumed, Pair::Parts]
                .map(|pair| difference(pair, &one, other).expect("they differ"))
        };
        let moved = of("moved/n.toml", "1", "vtu");
        assert_eq!(difference(Pair::Resumed, &one, &moved), None);
        let [since, beside] = found(&of("n.toml", "2", "vtu"));
        assert_eq!(since, "its schedule n.toml has changed since");
        assert_eq!(beside, "its schedule n.toml had other content");
        let [since, beside] = found(&of("n9.toml", "2", "vtu"));
        assert_eq!(
            since,
            "its schedule was n9.toml, with other content than n.toml"
        );
        assert_eq!(
            beside,
            "its schedule was n9.toml; the first part had n.toml, with other content"
        );
        let [since, beside] = found(&of("n.toml", "1", "su2"));
        assert_eq!(since, "its format was \"su2\"; now it is \"vtu\"");
        assert_eq!(beside, "its format was \"su2\"; the first part had \"vtu\"");
    }
}

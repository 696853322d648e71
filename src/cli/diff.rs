//! `azimesh diff`.

use super::{Context, Outcome};
use crate::error::{Error, Result};
use crate::mesh::difference::NodePair;
use crate::mesh::{Difference, Tolerance};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Arguments of `azimesh diff`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit code 0: the same; 1: a difference. -v lists each difference.")]
pub struct DiffArgs {
    /// First mesh
    a: PathBuf,
    /// Second mesh
    b: PathBuf,
    /// Largest distance of two nodes, and of two values of an array, that count as the same
    #[arg(long, value_name = "T", default_value_t = 0.0)]
    tolerance: f64,
    /// The tolerance is a fraction of the first mesh's diagonal, or of an array's largest value
    #[arg(long)]
    relative: bool,
}

pub(super) fn run(args: &DiffArgs, context: &Context) -> Result<Outcome> {
    if args.tolerance.is_nan() || args.tolerance < 0.0 {
        return Err(Error::input(format!(
            "--tolerance {}: it must not be negative",
            args.tolerance
        )));
    }
    let (a, b) = (context.read_mesh(&args.a)?, context.read_mesh(&args.b)?);
    let tolerance = Tolerance {
        value: args.tolerance,
        relative: args.relative,
    };
    let difference = Difference::between(&a, &b, tolerance);
    if context.common.json {
        context.print_json(as_json(&difference))?;
    } else {
        context.print(&format!("{difference}\n"))?;
        if context.common.verbose > 0 {
            context.print(&details(&difference))?;
        }
    }
    Ok(match difference.is_same() {
        true => Outcome::Fine,
        false => Outcome::CheckFailed,
    })
}

fn details(difference: &Difference) -> String {
    let mut lines = Vec::new();
    if let Some(pair) = difference.first_moved {
        lines.push(format!("first node that differs: {}", describe(&pair)));
    }
    if let (Some(pair), true) = (difference.furthest, difference.max_distance() > 0.0) {
        lines.push(format!("node that differs most: {}", describe(&pair)));
    }
    let sentences = [&difference.cells, &difference.groups, &difference.arrays];
    lines.extend(sentences.into_iter().flatten().cloned());
    lines.iter().map(|line| format!("  {line}\n")).collect()
}

fn describe(pair: &NodePair) -> String {
    let NodePair {
        node,
        a,
        b,
        distance,
    } = pair;
    format!("{node}, {a:?} and {b:?}, {distance:e} apart")
}

fn as_json(difference: &Difference) -> Value {
    let pair = |pair: &NodePair| json!({ "node": pair.node, "a": pair.a, "b": pair.b, "distance": pair.distance });
    json!({
        "same": difference.is_same(),
        "summary": difference.to_string(),
        "nodes": difference.n_nodes,
        "moved_nodes": difference.moved_nodes,
        "max_distance": difference.max_distance(),
        "first_moved": difference.first_moved.as_ref().map(pair),
        "furthest": difference.furthest.as_ref().map(pair),
        "cells": difference.n_cells,
        "changed_cells": difference.changed_cells,
        "cell_differences": difference.cells,
        "group_differences": difference.groups,
        "array_differences": difference.arrays,
    })
}

//! `azimesh convert`.

use super::output::OutputArgs;
use super::{Context, Outcome};
use crate::error::{Error, Result, nearest_name};
use crate::formats::{self, Format};
use crate::mesh::Mesh;
use std::path::{Path, PathBuf};

/// Arguments of `azimesh convert`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The input's format is found by its content; --format names that of the output \
where its ending does not."
)]
pub struct ConvertArgs {
    /// Mesh to read; - is standard input
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Mesh to write; - is standard output, with --format
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Multiply all coordinates, as 0.001 for millimetres to metres
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Rename a boundary tag or zone; repeatable
    #[arg(long, value_name = "OLD=NEW", value_parser = renaming)]
    rename_tag: Vec<(String, String)>,
    #[command(flatten)]
    write: OutputArgs,
}

fn renaming(text: &str) -> std::result::Result<(String, String), String> {
    match text.split_once('=') {
        Some((old, new)) if !old.is_empty() && !new.is_empty() => Ok((old.into(), new.into())),
        _ => Err("write OLD=NEW".into()),
    }
}

pub(super) fn run(args: &ConvertArgs, context: &Context) -> Result<Outcome> {
    let format = output_format(args, context)?;
    args.write.check(&args.output)?;
    let factor = args.scale.unwrap_or(1.0);
    if !factor.is_finite() || factor == 0.0 {
        return Err(Error::input(format!(
            "--scale {factor}: the factor must be a finite number other than 0"
        )));
    }
    let mut mesh = context.read_any(&args.input)?;
    rename(&mut mesh, &args.rename_tag).map_err(|error| error.file(&args.input))?;
    if args.scale.is_some() {
        for point in &mut mesh.points {
            *point = point.map(|x| x * factor);
        }
        // A scale that overflows is found before anything is written.
        mesh.validate().map_err(|error| error.file(&args.input))?;
    }
    args.write.save(&mesh, &args.output, format, context)?;
    report(&mesh, &args.output, format, context)?;
    Ok(Outcome::Fine)
}

fn output_format(args: &ConvertArgs, context: &Context) -> Result<&'static dyn Format> {
    match &context.common.format {
        Some(name) => formats::by_name(name),
        None => formats::by_extension(&args.output),
    }
}

/// Renames all at once, so that two tags can swap their names.
fn rename(mesh: &mut Mesh, renamings: &[(String, String)]) -> Result<()> {
    let names: Vec<String> = mesh.groups.iter().map(|group| group.name.clone()).collect();
    for (old, _) in renamings {
        if !names.contains(old) {
            let hint = nearest_name(old, names.iter().map(String::as_str))
                .map_or_else(String::new, |name| format!(" (did you mean \"{name}\"?)"));
            return Err(Error::input(format!(
                "--rename-tag: there is no \"{old}\"{hint}; there are: {}",
                names.join(", ")
            )));
        }
    }
    for group in &mut mesh.groups {
        if let Some((_, new)) = renamings.iter().find(|(old, _)| *old == group.name) {
            group.name.clone_from(new);
        }
    }
    for (i, group) in mesh.groups.iter().enumerate() {
        let twin = |other: &&crate::mesh::Group| {
            other.dimension == group.dimension && other.name == group.name
        };
        if mesh.groups[..i].iter().any(|other| twin(&other)) && !renamings.is_empty() {
            return Err(Error::input(format!(
                "--rename-tag: two groups would be called \"{}\"",
                group.name
            )));
        }
    }
    Ok(())
}

fn report(mesh: &Mesh, path: &Path, format: &dyn Format, context: &Context) -> Result<()> {
    if path.as_os_str() == "-" {
        return Ok(());
    }
    let (nodes, cells) = (mesh.points.len(), mesh.cells.len());
    if context.common.json {
        return context.print_json(serde_json::json!({
            "output": path.display().to_string(),
            "format": format.name(),
            "nodes": nodes,
            "cells": cells,
        }));
    }
    let path = path.display();
    context.detail(&format!("{path}: {nodes} nodes, {cells} cells"));
    Ok(())
}

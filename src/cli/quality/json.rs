//! The quality as JSON.

use super::worst::WorstCell;
use super::{Findings, Judged, Step};
use crate::cli::context::Entries;
use crate::record::Failure;
use azimesh_quality::{Assessment, Extreme, Statistic};
use serde::Serialize;

/// The quality of one mesh, at the top, or of a sequence, in `steps`, with the columns of steps.csv.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum QualityResult {
    /// One mesh.
    Mesh(Box<OneMesh>),
    /// A sequence.
    Sequence(Box<Sequence>),
}

/// A mesh.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OneMesh {
    #[serde(flatten)]
    quality: MeshQuality,
    /// Cells of negative volume in the order of their nodes, as in `info`.
    negative_cells: usize,
    /// Every metric by name.
    metrics: Entries<Metric>,
    #[serde(flatten)]
    checks: Checks,
}

/// A sequence.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Sequence {
    /// A row per step.
    steps: Vec<StepQuality>,
    /// The worst cell of all steps; null where several ranks share the work.
    worst_step: Option<Worst>,
    #[serde(flatten)]
    checks: Checks,
    /// By condition, the steps at which it holds.
    failed_steps: Entries<Vec<usize>>,
}

/// A step.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct StepQuality {
    /// Step, from 0.
    step: usize,
    /// Its time in the file; null where it has none.
    time: Option<f64>,
    #[serde(flatten)]
    quality: MeshQuality,
}

/// The quality of a mesh.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct MeshQuality {
    /// Cells of the mesh's own dimension, which have quality.
    cells: usize,
    /// Faces between two cells.
    inner_faces: usize,
    /// Faces of one cell.
    outer_faces: usize,
    /// Cells valid in the reference and inverted here; of one mesh without a reference, cells that are not valid.
    inverted: usize,
    /// Cells that are not valid in the reference (only their volume is checked), and solid cells with reversed nodes
    /// (checked as mirror images).
    inverted_reference: usize,
    /// Smallest volume, in 2D area, mesh units to the third or second power.
    min_volume: Option<f64>,
    /// Cell of `min_volume`.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_volume_cell: Option<usize>,
    /// Smallest scaled Jacobian.
    min_scaled_jacobian: Option<f64>,
    /// Cell of `min_scaled_jacobian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_scaled_jacobian_cell: Option<usize>,
    /// Mean scaled Jacobian.
    mean_scaled_jacobian: Option<f64>,
    /// First percentile of the scaled Jacobian.
    p01_scaled_jacobian: Option<f64>,
    /// Largest ratio of the edges of a cell.
    max_edge_ratio: Option<f64>,
    /// Cell of `max_edge_ratio`.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_edge_ratio_cell: Option<usize>,
    /// Largest equiangle skew.
    max_skew: Option<f64>,
    /// Cell of `max_skew`.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_skew_cell: Option<usize>,
    /// Largest non-orthogonality, degrees.
    max_non_orthogonality: Option<f64>,
    /// Cell of `max_non_orthogonality`.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_non_orthogonality_cell: Option<usize>,
    /// Mean non-orthogonality, degrees.
    mean_non_orthogonality: Option<f64>,
    /// Largest skewness of a face.
    max_face_skewness: Option<f64>,
    /// Cell of `max_face_skewness`.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_face_skewness_cell: Option<usize>,
    /// Smallest volume ratio of the two cells at a face.
    min_volume_ratio: Option<f64>,
    /// Cell of `min_volume_ratio`.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_volume_ratio_cell: Option<usize>,
    /// Smallest weight of a face.
    min_face_weight: Option<f64>,
    /// Cell of `min_face_weight`.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_face_weight_cell: Option<usize>,
    /// Smallest size-skew against the reference.
    min_size_skew: Option<f64>,
    /// Cell of `min_size_skew`.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_size_skew_cell: Option<usize>,
    /// Mean size-skew.
    mean_size_skew: Option<f64>,
    /// Cells valid at their corners, and neither proven to be so between them nor refuted.
    unproven: usize,
    /// Least Jacobian of a curved cell, relative to its mean in the cell with straight edges; only with curved cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_curved_jacobian: Option<f64>,
    /// Cell of `min_curved_jacobian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_curved_jacobian_cell: Option<usize>,
    /// Least scaled Jacobian of a curved cell; only with curved cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_curved_scaled_jacobian: Option<f64>,
    /// Cell of `min_curved_scaled_jacobian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_curved_scaled_jacobian_cell: Option<usize>,
    /// Sum of all volumes.
    total_volume: f64,
    /// Inverted cells, from 0, the first ones.
    inverted_cells: Vec<usize>,
}

/// A metric over all cells.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Metric {
    /// Cells that have it.
    cells: usize,
    /// Smallest value.
    min: Option<f64>,
    /// Mean of the finite values.
    mean: Option<f64>,
    /// Largest value; null where it is infinite.
    max: Option<f64>,
    /// Cell of the smallest.
    min_cell: Option<usize>,
    /// Cell of the largest.
    max_cell: Option<usize>,
}

/// The worst cells, and conditions that hold.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Checks {
    /// The worst cells; empty without `--worst`.
    worst: Vec<Worst>,
    /// Conditions of `--fail-on` that hold.
    failed_on: Vec<String>,
    /// The same with their numbers, one for each step where a condition holds.
    failures: Vec<Failure>,
}

/// A cell of `--worst N`.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Worst {
    /// Step of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<usize>,
    /// Number of the cell, from 0.
    cell: usize,
    /// Its kind.
    kind: &'static str,
    /// Mean of its nodes.
    position: [f64; 3],
    /// Its scaled Jacobian.
    scaled_jacobian: Option<f64>,
    /// Its volume or area.
    volume: Option<f64>,
    /// Tags that hold a face with one of its nodes.
    tags: Vec<String>,
    /// Nearest boundary tag; null without tags.
    nearest_tag: Option<String>,
    /// Distance to it, mesh units.
    distance: Option<f64>,
}

impl QualityResult {
    pub(super) fn of(findings: &Findings<'_>) -> Self {
        let checks = Checks::of(findings);
        if let (
            [
                Judged {
                    step: None,
                    quality,
                    ..
                },
            ],
            Some(metrics),
        ) = (&findings.meshes[..], &findings.metrics)
        {
            let metrics = metrics
                .iter()
                .map(|metric| (metric.name, Metric::of(metric)));
            return Self::Mesh(Box::new(OneMesh {
                quality: MeshQuality::of(quality),
                negative_cells: findings.flaws.negative.n,
                metrics: metrics.collect(),
                checks,
            }));
        }
        let steps = findings.meshes.iter().filter_map(|mesh| {
            let Step { index, time } = mesh.step?;
            Some(StepQuality {
                step: index,
                time: Some(time),
                quality: MeshQuality::of(&mesh.quality),
            })
        });
        let failed = findings.met().into_iter().map(|(criterion, met)| {
            let steps = met.iter().filter_map(|(step, _)| *step);
            (criterion.to_string(), steps.collect())
        });
        Self::Sequence(Box::new(Sequence {
            steps: steps.collect(),
            worst_step: findings.worst_of_sequence().map(Worst::of),
            checks,
            failed_steps: failed.collect(),
        }))
    }
}

impl MeshQuality {
    fn of(quality: &Assessment) -> Self {
        let Assessment { cells, faces } = quality;
        let value = |extreme: Option<Extreme>| extreme.map(|extreme| extreme.value);
        let cell = |extreme: Option<Extreme>| extreme.map(|extreme| extreme.cell);
        Self {
            cells: cells.n_cells,
            inner_faces: faces.n_inner,
            outer_faces: faces.n_outer,
            inverted: cells.inverted,
            inverted_reference: cells.inverted_reference,
            min_volume: value(cells.min_volume),
            min_volume_cell: cell(cells.min_volume),
            min_scaled_jacobian: value(cells.min_scaled_jacobian),
            min_scaled_jacobian_cell: cell(cells.min_scaled_jacobian),
            mean_scaled_jacobian: cells.mean_scaled_jacobian,
            p01_scaled_jacobian: cells.p01_scaled_jacobian,
            min_curved_jacobian: value(cells.min_curved[0]),
            min_curved_jacobian_cell: cell(cells.min_curved[0]),
            min_curved_scaled_jacobian: value(cells.min_curved[1]),
            min_curved_scaled_jacobian_cell: cell(cells.min_curved[1]),
            max_edge_ratio: value(cells.max_edge_ratio),
            max_edge_ratio_cell: cell(cells.max_edge_ratio),
            max_skew: value(cells.max_skew),
            max_skew_cell: cell(cells.max_skew),
            max_non_orthogonality: value(faces.max_non_orthogonality),
            max_non_orthogonality_cell: cell(faces.max_non_orthogonality),
            mean_non_orthogonality: faces.mean_non_orthogonality,
            max_face_skewness: value(faces.max_face_skewness),
            max_face_skewness_cell: cell(faces.max_face_skewness),
            min_volume_ratio: value(faces.min_volume_ratio),
            min_volume_ratio_cell: cell(faces.min_volume_ratio),
            min_face_weight: value(faces.min_face_weight),
            min_face_weight_cell: cell(faces.min_face_weight),
            min_size_skew: value(cells.size_skew.min),
            min_size_skew_cell: cell(cells.size_skew.min),
            mean_size_skew: cells.size_skew.mean,
            unproven: cells.unproven,
            total_volume: cells.total_volume,
            inverted_cells: cells.inverted_cells.clone(),
        }
    }
}

impl Metric {
    fn of(metric: &Statistic) -> Self {
        Self {
            cells: metric.n_cells,
            min: metric.min.map(|extreme| extreme.value),
            mean: metric.mean,
            max: metric.max.map(|extreme| extreme.value),
            min_cell: metric.min.map(|extreme| extreme.cell),
            max_cell: metric.max.map(|extreme| extreme.cell),
        }
    }
}

impl Checks {
    fn of(findings: &Findings<'_>) -> Self {
        let met = findings.met();
        let failures = met.iter().flat_map(|(_, met)| met);
        Self {
            worst: findings.listed().iter().map(Worst::of).collect(),
            failed_on: met
                .iter()
                .map(|(criterion, _)| criterion.to_string())
                .collect(),
            failures: failures.map(|(_, note)| Failure::from(note)).collect(),
        }
    }
}

impl Worst {
    fn of(cell: &WorstCell) -> Self {
        let (nearest_tag, distance) = cell.nearest.clone().unzip();
        Self {
            step: cell.step.map(|step| step.index),
            cell: cell.found.cell,
            kind: cell.kind,
            position: cell.position,
            scaled_jacobian: Some(cell.found.scaled_jacobian),
            volume: Some(cell.found.volume),
            tags: cell.tags.clone(),
            nearest_tag,
            distance,
        }
    }
}

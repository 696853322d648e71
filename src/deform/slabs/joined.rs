//! All slabs joined: where nodes are, and what cells are like, from the files that slabs have left.

use super::super::mesh_file::MeshFile;
use super::super::numbers_file::{NumbersFile, failed};
use super::super::plan::Plan;
use super::super::velocity::IntoInertial;
use super::SlabOf;
use super::stored::{Act, StoredStep, ToldOfStep};
use crate::error::{Error, Result};
use crate::geometry::vector::{Vector, sub};
use crate::mesh::{Apart, Mesh, Numbers, Part, Slots, among, node_slab};
use crate::parallel;
use crate::quality::faces::FaceSummary;
use crate::quality::{Judge, Summary};
use crate::ranks::hash::HashedBytes;
use crate::ranks::{Ranks, Told, processor};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Nodes between two that are wanted that are read with them.
const GAP: u32 = 64;
/// Nodes that are read at once.
const NODES: u32 = 1 << 16;

/// The slabs of a sequence.
#[derive(Debug)]
pub struct Joined {
    /// Of which the outline is read, where this process does not have the whole mesh.
    pub(in crate::deform) file: Option<Arc<MeshFile>>,
    sequence: PathBuf,
    n: usize,
    /// Of what they are, once that is known.
    of: OnceLock<Of>,
    /// The step that was entered last, and what slabs tell of it.
    told: Mutex<(usize, Vec<ToldOfStep>)>,
}

/// What slabs are slabs of.
#[derive(Debug)]
struct Of {
    /// What tells their run from others.
    run: [u8; 32],
    n_nodes: usize,
    dimension: u8,
    is_level: bool,
}

impl Joined {
    pub(super) fn new(file: Option<Arc<MeshFile>>, sequence: &Path, n: usize) -> Self {
        Self {
            file,
            sequence: sequence.to_path_buf(),
            n,
            of: OnceLock::new(),
            told: Mutex::new((usize::MAX, Vec::new())),
        }
    }

    /// The same slabs of another file, if they are of one.
    pub(in crate::deform) fn of_file(
        &self,
        other: impl FnOnce(&Arc<MeshFile>) -> Arc<MeshFile>,
    ) -> Self {
        Self::new(self.file.as_ref().map(other), &self.sequence, self.n)
    }

    /// How many slabs there are.
    pub(crate) fn n(&self) -> usize {
        self.n
    }

    /// The folder of each slab.
    pub(crate) fn folders(&self) -> impl Iterator<Item = PathBuf> {
        SlabOf::all(self.n).map(|slab| slab.folder(&self.sequence))
    }

    /// Refuses slabs that lack a step of a plan, or are not of this run.
    pub(crate) fn check(&self, run: [u8; 32], plan: &Plan) -> Result<()> {
        self.of.get_or_init(|| Of {
            run,
            n_nodes: plan.mesh.points.len(),
            dimension: plan.mesh.dimension(),
            // Nobody asks for that of a solid mesh, of which there may be an outline here.
            is_level: plan.mesh.dimension() < 3 && plan.mesh.is_level(),
        });
        for slab in SlabOf::all(self.n) {
            for step in 0..plan.motion.steps.len() {
                let path = self.path(slab, step);
                if !path
                    .try_exists()
                    .map_err(|error| Error::io(&path, &error))?
                {
                    return Err(Error::input(format!(
                        "slab {slab} has no step {step}: `azimesh deform --slab {slab} --resume`, with the mesh and the schedule of \
                         the others, writes what it lacks, or tells why not"
                    ))
                    .file(&slab.folder(&self.sequence)));
                }
                self.open(slab, step)?;
            }
        }
        Ok(())
    }

    fn of(&self) -> &Of {
        self.of
            .get()
            .expect("slabs are checked before they are used")
    }

    /// The kinds of processors on which so many steps of the slabs were computed, where these are several.
    pub(crate) fn kinds_of_processors(&self, n_steps: usize) -> Option<String> {
        let all = SlabOf::all(self.n).flat_map(|slab| (0..n_steps).map(move |step| (slab, step)));
        let found = all.filter_map(|(slab, step)| StoredStep::open(&self.path(slab, step)).ok());
        processor::several(found.map(|stored| stored.processor().to_owned()).collect())
    }

    /// Opens what a slab has left of a step.
    fn open(&self, slab: SlabOf, step: usize) -> Result<StoredStep> {
        let path = self.path(slab, step);
        let found = StoredStep::open(&path)?;
        let of = self.of();
        let nodes = node_slab(of.n_nodes, slab.number, self.n);
        match (found.run(), found.step(), found.nodes()) == (of.run, step, nodes) {
            true => Ok(found),
            false => Err(Error::input(
                "this is a step of another mesh, schedule, option or version of azimesh",
            )
            .file(&path)),
        }
    }

    fn path(&self, slab: SlabOf, step: usize) -> PathBuf {
        slab.folder(&self.sequence)
            .join(StoredStep::file_name(step))
    }

    fn steps(&self, step: usize) -> impl Iterator<Item = Result<StoredStep>> {
        SlabOf::all(self.n).map(move |slab| self.open(slab, step))
    }

    /// The positions at a step of a plan, from where they are written.
    pub(crate) fn points(self: &Arc<Self>, step: usize, plan: &Arc<Plan>) -> StoredPoints {
        StoredPoints {
            by: Arc::clone(self),
            step,
            plan: Arc::clone(plan),
        }
    }

    /// Reads the velocities of all nodes at a step, in the frame of the rotor.
    ///
    /// # Errors
    /// Where a file cannot be read or is damaged, or has none.
    pub(crate) fn read_velocities(&self, step: usize, out: &mut [Vector]) -> Result<()> {
        self.pass(step, true, &mut |first, _, velocities| {
            out[first..first + velocities.len()].copy_from_slice(velocities);
            Ok(())
        })
    }

    /// Passes what slabs have left of a step.
    fn pass(&self, step: usize, velocities: bool, act: &mut Act<'_>) -> Result<()> {
        self.steps(step)
            .try_for_each(|stored| stored?.pass_both(velocities, act))
    }

    fn told(&self) -> MutexGuard<'_, (usize, Vec<ToldOfStep>)> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes to `out` where the nodes are at a step, which have `slots` there: those that are `known`, ascending, or all. From then on
    /// its quality can be had. Gives the largest displacement error before the correction.
    ///
    /// # Errors
    /// Where a file cannot be read or is damaged, of which coordinates are checked where all are read, and where a slab was not
    /// moved by the base points with this hash.
    pub(crate) fn enter(
        &self,
        step: usize,
        base: [u8; 32],
        known: Option<&[u32]>,
        (slots, out): (Slots<'_>, &mut [Vector]),
    ) -> Result<f64> {
        let mut told = Vec::new();
        let mut error: f64 = 0.0;
        for stored in self.steps(step) {
            let mut stored = stored?;
            let moved = stored.moved();
            error = error.max(moved.selection_error);
            if moved.base != base {
                return Err(stored.wrong(
                    "this step was moved by other base points than those of the other slabs, as where several slabs have chosen them at \
                     once on several kinds of processors; save them with `azimesh select` and run all slabs with --base, and on processors of one kind where there are velocities",
                ));
            }
            match known {
                None => stored.pass(&mut |first, points| {
                    out[first..first + points.len()].copy_from_slice(points);
                    Ok(())
                })?,
                Some(known) => {
                    let nodes = stored.nodes();
                    read_some(&mut stored, among(known, &nodes), (slots, out))?;
                }
            }
            told.push(stored.into_told());
        }
        *self.told() = (step, told);
        Ok(error)
    }

    /// The nodes are not where slabs have left them any more.
    pub(crate) fn leave(&self) {
        *self.told() = (usize::MAX, Vec::new());
    }

    /// Whether the nodes are where slabs have left them at a step.
    pub(crate) fn is_at(&self, step: usize) -> bool {
        self.told().0 == step
    }

    /// The quality of the cells at the step that was entered last.
    pub(crate) fn cells(&self, step: usize) -> Summary {
        let mesh = self.hearing(step, |told| &told.cells);
        Judge::new(&mesh).cells(&mesh, &[])
    }

    /// The quality of its faces.
    pub(crate) fn faces(&self, step: usize) -> FaceSummary {
        let mesh = self.hearing(step, |told| &told.faces);
        Judge::new(&mesh).faces(&mesh, &[])
    }

    /// The largest change of the angle between a moving wall and its first cell, in degrees.
    pub(crate) fn normal_change(&self, step: usize) -> Option<f64> {
        let mesh = self.hearing(step, |told| &told.walls);
        // As is told of the mesh at rest, which nobody asks for here.
        Judge::new(&mesh);
        let all = mesh.ranks().all(None::<f64>);
        all.into_iter().flatten().max_by(f64::total_cmp)
    }

    /// A mesh without cells: what is asked of it is what all slabs tell.
    fn hearing(&self, step: usize, of: impl Fn(&ToldOfStep) -> &Told) -> Mesh {
        let told = self.told();
        assert_eq!(told.0, step, "a step is entered before it is judged");
        let of_slab = |told: &ToldOfStep| [&told.at_rest[..], of(told)].concat();
        let of = self.of();
        let part = Part {
            ranks: Ranks::hearing(told.1.iter().map(of_slab).collect()),
            is_level: of.is_level,
            ..Part::default()
        };
        Mesh {
            space: Some(of.dimension),
            part: Some(Arc::new(part)),
            ..Mesh::default()
        }
    }
}

/// Reads where some of the nodes of a step are, which have `slots` in `out`.
fn read_some(
    stored: &mut StoredStep,
    nodes: &[u32],
    (slots, out): (Slots<'_>, &mut [Vector]),
) -> Result<()> {
    let mut rest = nodes;
    while let Some(&first) = rest.first() {
        let is_near = |pair: &[u32]| pair[1] - pair[0] <= GAP && pair[1] - first < NODES;
        let n = 1 + rest.windows(2).take_while(|pair| is_near(pair)).count();
        let end = rest[n - 1] as usize + 1;
        let mut points = vec![[0.0; 3]; end - first as usize];
        stored.read(first as usize..end, &mut points)?;
        for &node in &rest[..n] {
            out[slots.of(node)] = points[(node - first) as usize];
        }
        rest = &rest[n..];
    }
    Ok(())
}

/// Where the nodes are at a step.
pub(crate) struct StoredPoints {
    by: Arc<Joined>,
    step: usize,
    plan: Arc<Plan>,
}

impl std::fmt::Debug for StoredPoints {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "positions of step {} with {} slabs",
            self.step, self.by.n
        )
    }
}

impl Apart for StoredPoints {
    fn write(
        &self,
        to: Option<(&Path, u64)>,
        numbers: &Numbers,
        hash_from: u64,
    ) -> Result<Vec<HashedBytes>> {
        let file = self.by.file.as_deref();
        let mut out = NumbersFile::new(to, hash_from, &failed)?;
        let pass = |act: &mut Act<'_>| self.by.pass(self.step, false, act);
        match numbers {
            Numbers::Nodes(_) => {
                let file = file.expect("cells are apart where there is the outline of a mesh");
                return file.write(to, numbers, hash_from);
            }
            Numbers::Coordinates(wanted) => {
                pass(&mut |first, points, _| out.points(points, first, *wanted))?;
            }
            Numbers::Velocities(wanted) => {
                let (plan, steps) = (&*self.plan, &self.plan.motion.steps);
                self.by
                    .pass(self.step, true, &mut |first, points, velocities| {
                        let mut velocities = velocities.to_vec();
                        let step = &steps[self.step];
                        IntoInertial::turn(plan, step, first, points, &mut velocities);
                        out.points(&velocities, first, *wanted)
                    })?;
            }
            Numbers::Displacements(wanted) => {
                let mut take = |first, points: &[Vector], rest: &[Vector]| {
                    let moved = parallel::collect(points.len(), |i| sub(points[i], rest[i]));
                    out.points(&moved, first, *wanted)
                };
                match file {
                    None => {
                        let rest = &self.plan.mesh.points;
                        pass(&mut |first, points, _| take(first, points, &rest[first..]))
                    }
                    Some(file) => file.file().by_pieces(|slabs, _| {
                        pass(&mut |first, points, _| {
                            let rest = (slabs.points)(first..first + points.len())?;
                            take(first, points, &rest)
                        })
                    }),
                }?;
            }
        }
        Ok(out.finish().0)
    }
}

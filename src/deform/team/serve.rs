//! What all ranks do alike for an order of the first: the others wait for orders here.

use super::kept::share_wanted;
use super::near_surface::WholeSurface;
use super::nodes::{Nodes, OfNodes};
use super::order::{Order, RowsFrom, Task};
use super::placing::Numbered;
use super::shared_correction::correct;
use super::work::Work;
use super::{outline, sweeps};
use crate::formats::{SharedFile, read_parts};
use crate::geometry::Bounds;
use crate::geometry::boxes::Boxes;
use crate::geometry::vector::Vector;
use crate::mesh::{Mesh, node_slab};
use crate::progress::{Progress, Silent};
use crate::ranks::Ranks;
use crate::ranks::raw::List;

/// Tells the other ranks that there is no more to do.
pub fn dismiss(ranks: &Ranks) {
    if ranks.n() > 1 {
        Order::give(Some(Order::End), ranks);
    }
}

/// Does what the first rank orders, until there is no more to do.
pub fn serve(ranks: &Ranks) {
    let mut work = Work::default();
    let mut surface = None;
    let nothing = |_: usize, _: &mut [Vector]| {};
    loop {
        match Order::give(None, ranks) {
            Order::Select(order) => sweeps::serve(&mut surface, &order, ranks),
            Order::Evaluate { id, task } => {
                let from = ranks.scatter(&mut |_| None);
                evaluate((id, *task, from), &mut work, None, ranks, &Silent);
            }
            Order::Move {
                id,
                step,
                from_zero,
                stays,
            } => work.move_to((id, step, from_zero), stays, |own| ranks.send_part(own)),
            Order::Fade { boxes } => fade(&mut work, boxes, None, ranks),
            Order::Forget { id } => work.forget(id),
            Order::Read { file, tells } => outline::read(&mut work, (&file, tells), ranks),
            Order::Hash(file) => {
                ranks.gather(outline::hash_of_share(&file, ranks));
            }
            Order::Edges => drop(outline::edges(&work, None, ranks)),
            Order::LooseFaces(faces) => {
                ranks.gather(outline::loose_faces(&work, &faces));
            }
            Order::Share {
                is_read,
                file,
                n_nodes,
                moving_faces,
            } => {
                let read = work.read.take().filter(|_| is_read);
                let part = read.or_else(|| file.and_then(|file| part_of_file(&file, ranks).ok()));
                let part = part.unwrap_or_else(|| Mesh::shared_of(None, ranks));
                let moving_faces = moving_faces.as_deref();
                take_part(&mut work, part, moving_faces, (n_nodes, None), ranks);
                ranks.gather(work.told());
            }
            Order::TakeNodes { n_nodes } => {
                let rest = ranks.scatter(&mut |_| None);
                work.nodes = nodes_alone((n_nodes, rest), None, ranks);
                ranks.gather(work.told());
            }
            Order::Numbers => drop(ranks.gather(work.numbers())),
            Order::EndMove { maps, rounding } => work.end_move(&maps, rounding),
            Order::EndVelocities(rates) => {
                let mut told = vec![[0.0; 3]; work.nodes.apart.told.len()];
                ranks.scatter_into(&nothing, &mut told, &[]);
                work.end_velocities(&rates, &told);
            }
            Order::PlaceApart => {
                let mut places = vec![[0.0; 3]; work.nodes.apart.told.len()];
                ranks.scatter_into(&nothing, &mut places, &[]);
                work.take_told(&places);
            }
            Order::PlaceRest => {
                ranks.send_part(&work.hashes());
                work.correct(ranks.scatter(&mut |_| None));
            }
            Order::Divide => work.wanted = share_wanted(None, ranks),
            Order::Collect => ranks.send_part(work.own_places()),
            Order::Keep => work.keep(),
            Order::Write(task) => drop(ranks.gather(work.write(&task, ranks))),
            Order::Settle => drop(ranks.agree(work.settle(ranks))),
            Order::Cells => drop(work.cells()),
            Order::Faces => drop(work.faces()),
            Order::Walls => drop(work.normal_change()),
            Order::End => return,
        }
    }
}

/// Adds to where the nodes of a rank are what fades in from the surface, which the first has.
pub(super) fn fade(
    work: &mut Work,
    boxes: Vec<Bounds>,
    whole: Option<&WholeSurface<'_>>,
    ranks: &Ranks,
) {
    let mut places = work.take_places();
    if !boxes.is_empty() {
        correct(work.moved(&mut places), Boxes::new(boxes), whole, ranks);
    }
    // What is out of reach gets a zero, as in one process: of -0.0 it makes 0.0.
    let mut moved = work.moved(&mut places);
    ranks.together(|| moved.add_zero());
    work.nodes.places = places;
}

/// The part of each rank, which reads it from the file.
///
/// # Errors
/// Why it is not read, on all ranks.
pub(super) fn part_of_file(file: &SharedFile, ranks: &Ranks) -> std::result::Result<Mesh, String> {
    ranks.together(|| read_parts(file, ranks))
}

/// Takes a part of a mesh of so many nodes, of which the first rank knows more.
pub(super) fn take_part(
    work: &mut Work,
    part: Mesh,
    moving_faces: Option<&[u32]>,
    (n_nodes, of_first): (usize, Option<&OfNodes<'_>>),
    ranks: &Ranks,
) {
    let numbers = part.part.as_ref().map(|part| &part.nodes[..]);
    let numbered = Numbered {
        n_nodes,
        all: numbers,
    };
    let nodes = Nodes::share(of_first, &numbered, ranks);
    ranks.together(|| work.take_part(part, moving_faces, nodes));
}

/// The own nodes of a rank alone.
pub(super) fn nodes_alone(
    (n_nodes, List(rest)): (usize, List<Vector>),
    of_first: Option<&OfNodes<'_>>,
    ranks: &Ranks,
) -> Nodes {
    let numbered = Numbered { n_nodes, all: None };
    let first = node_slab(n_nodes, ranks.rank(), ranks.n()).start;
    Nodes::share(of_first, &numbered, ranks).alone(first, rest)
}

/// Evaluates fields at the own nodes of a rank, corrects them with all others, and gets them at the other nodes of its part from the
/// ranks that these belong to. The first has the whole surface.
pub(super) fn evaluate(
    (id, task, from): (usize, Task, RowsFrom),
    work: &mut Work,
    whole: Option<&WholeSurface<'_>>,
    ranks: &Ranks,
    progress: &dyn Progress,
) {
    ranks.together(|| work.evaluate(id, task.layers, from, progress));
    if !task.boxes.is_empty() {
        ranks.is_for("correction");
        let boxes = Boxes::new(task.boxes);
        correct(work.own_fields(id), boxes, whole, ranks);
    }
    ranks.is_for("fields");
    work.get_others(id, ranks);
}

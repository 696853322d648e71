//! Structured zones: hexahedra, quadrilaterals or lines, and the faces of their boundary conditions.

use super::super::grid::Grid;
use super::super::vtk::structured;
use super::builder::MeshBuilder;
use super::regions::{Families, GridLocation, Region, regions};
use super::zone::Zone;
use crate::mesh::Cells;
use azimesh_core::error::{Error, Result};
use std::collections::BTreeSet;
use std::ops::Range;

/// Appends the cells of a structured zone and the faces of its boundary conditions.
pub(super) fn read(zone: &Zone, families: &Families, found: &mut MeshBuilder) -> Result<()> {
    let grid = Grid::of(zone)?;
    found.cells.check_space(grid.cells.iter().product())?;
    structured::append(&mut found.cells, grid.nodes, grid.first_node as u32);
    for region in regions(zone, families, found)? {
        if region.place == GridLocation::CellCenters && grid.is_solid(&region) {
            found.leave_named("groups of cells of structured zones", region.node.name());
            continue;
        }
        let start = found.cells.len();
        if region.is_range {
            grid.append_range(&region, &mut found.cells)?;
        } else {
            grid.append_list(&region, &mut found.cells)?;
        }
        let cells = start..found.cells.len();
        region.tag(&[cells], zone, found);
    }
    Ok(())
}

/// Numbers of nodes or cells along the indices, in a sentence.
fn sizes(along: &[usize]) -> String {
    let along: Vec<String> = along.iter().map(usize::to_string).collect();
    along.join(" x ")
}

impl Grid {
    fn of(zone: &Zone) -> Result<Self> {
        let size = |i: usize| zone.n_nodes.get(i).copied().unwrap_or(1);
        let nodes = std::array::from_fn(size);
        zone.total_nodes()?;
        if zone.n_nodes.iter().any(|&n| n < 2) {
            return Err(zone.node.refuse(format!(
                "it has {} nodes; it must have at least 2 along each index",
                sizes(&zone.n_nodes)
            )));
        }
        Ok(Self::new(zone.n_nodes.len(), nodes, zone.first_node))
    }

    /// Tests if a region spreads along all indices: it is a part of the grid, no boundary.
    fn is_solid(&self, region: &Region) -> bool {
        let (low, high) = region.numbers.split_at(region.numbers.len() / 2);
        let wide = low.iter().zip(high).filter(|(a, b)| a != b).count();
        region.is_range && wide == self.n_indices
    }

    /// Appends the faces in a range of nodes, of faces, or of their adjacent cells.
    fn append_range(&self, region: &Region, cells: &mut Cells) -> Result<()> {
        let n = self.n_indices;
        if region.numbers.len() != 2 * n {
            return Err(region.node.refuse(format!(
                "its range has {} numbers; in a zone with {n} indices it must have {}",
                region.numbers.len(),
                2 * n
            )));
        }
        let (mut low, mut high) = ([1_usize; 3], [1_usize; 3]);
        for i in 0..n {
            let ends = [region.numbers[i], region.numbers[n + i]];
            let ends = ends.map(|end| usize::try_from(end).unwrap_or(0));
            (low[i], high[i]) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            if low[i] < 1 || high[i] > self.nodes[i] {
                return Err(region.node.refuse(format!(
                    "its range {:?} is not within the zone of {} nodes",
                    region.numbers,
                    sizes(&self.nodes[..n])
                )));
            }
        }
        let Some(across) = self.across(region, low, high) else {
            return Ok(());
        };
        let counts_nodes = region.place == GridLocation::Nodes
            || (0..n).any(|i| i != across && high[i] > self.cells[i]);
        let layer = layer(region, low[across] - 1);
        let mut ranges: [Range<usize>; 3] = [0..1, 0..1, 0..1];
        for i in (0..n).filter(|&i| i != across) {
            ranges[i] = if counts_nodes {
                low[i] - 1..high[i] - 1
            } else {
                low[i] - 1..high[i]
            };
        }
        ranges[across] = layer..layer + 1;
        self.append_faces(across, ranges, cells);
        Ok(())
    }

    /// The constant index of a range, at an end of the zone if
    /// there are several.
    fn across(&self, region: &Region, low: [usize; 3], high: [usize; 3]) -> Option<usize> {
        if let GridLocation::FacesAcross(index) = region.place {
            return Some(index).filter(|i| *i < self.n_indices && low[*i] == high[*i]);
        }
        let flat: Vec<usize> = (0..self.n_indices).filter(|&i| low[i] == high[i]).collect();
        let last = |i: usize| match region.place {
            GridLocation::CellCenters => self.cells[i],
            _ => self.nodes[i],
        };
        let at_end = |&&i: &&usize| low[i] == last(i) || low[i] == 1;
        let beyond_cells =
            |&&i: &&usize| region.place != GridLocation::CellCenters && low[i] > self.cells[i];
        let mut ends = flat.iter();
        flat.iter()
            .find(beyond_cells)
            .or_else(|| ends.find(at_end))
            .or(flat.first())
            .copied()
    }

    /// Appends the faces given by a list: all faces of the six sides with only such nodes, the
    /// faces that are named, or the faces of the cells that are named.
    fn append_list(&self, region: &Region, cells: &mut Cells) -> Result<()> {
        let n = self.n_indices;
        let mut points: BTreeSet<[usize; 3]> = BTreeSet::new();
        for numbers in region.numbers.chunks(n) {
            let mut point = [0; 3];
            for (i, &number) in numbers.iter().enumerate() {
                point[i] = usize::try_from(number.saturating_sub(1)).unwrap_or(usize::MAX);
            }
            if numbers.len() < n || (0..n).any(|i| point[i] >= self.nodes[i]) {
                return Err(self.outside(region, numbers));
            }
            points.insert(point);
        }
        let Some(across) = self.across_list(region, &points) else {
            if region.place != GridLocation::CellCenters {
                self.append_sides(&points, cells);
            }
            return Ok(());
        };
        for point in &points {
            let counts_faces = |i: usize| i == across && region.place != GridLocation::CellCenters;
            if (0..n).any(|i| !counts_faces(i) && point[i] >= self.cells[i]) {
                return Err(self.outside(region, &point.map(|i| i as i64 + 1)[..n]));
            }
            let mut ranges = point.map(|i| i..i + 1);
            let layer = layer(region, point[across]);
            ranges[across] = layer..layer + 1;
            self.append_faces(across, ranges, cells);
        }
        Ok(())
    }

    fn outside(&self, region: &Region, numbers: &[i64]) -> Error {
        let n = self.n_indices;
        let message = format!(
            "its list has {numbers:?}, which is not in the zone of {} nodes and {} cells",
            sizes(&self.nodes[..n]),
            sizes(&self.cells[..n])
        );
        region.node.refuse(message)
    }

    /// The constant index of the faces of a list; `None` for a list of nodes.
    fn across_list(&self, region: &Region, points: &BTreeSet<[usize; 3]>) -> Option<usize> {
        let ends = |i: usize| {
            let places = || points.iter().map(|point| point[i]);
            [places().min().unwrap_or(0), places().max().unwrap_or(0)]
        };
        let at_end = |i: &usize| {
            let [low, high] = ends(*i);
            low == high && (low == 0 || low + 1 == self.nodes[*i])
        };
        match region.place {
            GridLocation::FacesAcross(index) => Some(index).filter(|index| *index < self.n_indices),
            GridLocation::Elements => (0..self.n_indices).find(at_end),
            GridLocation::CellCenters => {
                let ends: [[usize; 2]; 3] = std::array::from_fn(ends);
                self.across(
                    region,
                    ends.map(|[low, _]| low + 1),
                    ends.map(|[_, high]| high + 1),
                )
            }
            GridLocation::Nodes => None,
        }
    }

    fn append_sides(&self, points: &BTreeSet<[usize; 3]>, cells: &mut Cells) {
        for across in 0..self.n_indices {
            for side in [0, self.nodes[across] - 1] {
                for point in points.iter().filter(|point| point[across] == side) {
                    let others = (0..self.n_indices).filter(|&i| i != across);
                    let others: Vec<usize> = others.collect();
                    let all = (0..1_usize << others.len()).all(|corner| {
                        let mut place = *point;
                        for (bit, &index) in others.iter().enumerate() {
                            place[index] += corner >> bit & 1;
                        }
                        points.contains(&place)
                    });
                    if all {
                        self.append_faces(across, point.map(|i| i..i + 1), cells);
                    }
                }
            }
        }
    }
}

/// Positions of faces that are given by their own index or by the index of their adjacent cells, which have
/// them on their far side unless they are the first.
fn layer(region: &Region, index: usize) -> usize {
    index + usize::from(region.place == GridLocation::CellCenters && index > 0)
}

#[cfg(test)]
mod tests {
    use super::super::node::Node;
    use super::*;
    use crate::formats::Source;
    use crate::formats::hdf5::Tree;
    use crate::testing::assert_says;
    use std::path::Path;

    /// The faces that a list gives in a grid of 3 nodes along each index.
    fn listed(place: GridLocation, numbers: &[[i64; 3]]) -> Result<Cells> {
        let mut bytes = Vec::new();
        Tree::new().write(&mut bytes).expect("it can be written");
        let source = Source::from_bytes(Path::new("<memory>"), bytes);
        let node = Node::root(&source).expect("a file without nodes").0;
        let region = Region {
            node: &node,
            names: Vec::new(),
            condition: None,
            place,
            says_place: true,
            dimension: 2,
            numbers: numbers.concat(),
            is_range: false,
        };
        let grid = Grid::new(3, [3; 3], 0);
        let mut cells = Cells::new();
        grid.append_list(&region, &mut cells).map(|()| cells)
    }

    #[test]
    fn a_list_of_cells_names_the_faces_on_their_outer_side() {
        for (i, expected) in [(1, 0), (2, 2)] {
            let beside = [[i, 1, 1], [i, 2, 1], [i, 1, 2], [i, 2, 2]];
            let faces = listed(GridLocation::CellCenters, &beside).expect("a good list");
            assert_eq!(faces.len(), 4);
            assert!(faces.connectivity().iter().all(|node| node % 3 == expected));
        }
        let solid = [[1, 1, 1], [2, 2, 2]];
        let faces = listed(GridLocation::CellCenters, &solid).expect("no list of a side");
        assert!(faces.is_empty());
        assert!(listed(GridLocation::CellCenters, &[[3, 1, 1]]).is_err());
    }

    #[test]
    fn a_face_beyond_the_last_is_refused() {
        let last = listed(GridLocation::FacesAcross(0), &[[3, 2, 2]]).expect("the last face");
        assert_eq!(last.len(), 1);
        for number in [[1, 3, 1], [1, 1, 3], [4, 1, 1]] {
            let error = listed(GridLocation::FacesAcross(0), &[number]).expect_err("no such face");
            assert_says(&error, "which is not in");
        }
    }
}

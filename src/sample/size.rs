//! The size of a sample: its options, checked once.

use azimesh_core::error::{Error, Result};

/// Height of the wall cells, in chords, when none is given.
const FIRST_CELL: f64 = 1e-5;

/// The most nodes a sample can have.
const MOST_NODES: usize = 400_000_000;

/// Options of the size. What is left out follows from the rest.
#[derive(Debug, Clone, Copy, Default, PartialEq, clap::Args)]
pub struct SizeOptions {
    /// Number of nodes, as closely as the grid allows
    #[arg(long, value_name = "N")]
    pub nodes: Option<usize>,
    /// Number of nodes on the wall and the outer boundary together
    #[arg(long, value_name = "N")]
    pub surface_nodes: Option<usize>,
    /// Number of layers of cells from the wall to the outer boundary
    #[arg(long, value_name = "N")]
    pub layers: Option<usize>,
    /// Height of the wall cells in chords [default: 1e-5]
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    pub first_cell: Option<f64>,
}

/// A checked size: layers that all have about the same number of nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Nodes wanted on the wall.
    pub wall_nodes: usize,
    /// Layers of cells; left out, chosen once the true number of wall nodes is known.
    layers: Option<usize>,
    nodes: usize,
    /// Height of the wall cells, in chords.
    pub first_cell: f64,
}

impl SizeOptions {
    /// Checks the options. `nodes` are wanted where nothing else says it; `usual_layers` gives the
    /// layers that suit a number of nodes; a wall needs `least_wall` nodes.
    pub fn resolve(
        &self,
        nodes: usize,
        usual_layers: impl Fn(usize) -> usize,
        least_wall: usize,
    ) -> Result<Size> {
        self.check_ranges()?;
        let [n, surface, layers] = [self.nodes, self.surface_nodes, self.layers];
        if n.is_some() && surface.is_some() && layers.is_some() {
            return Err(Error::input(
                "--nodes, --surface-nodes and --layers cannot all be given: two of them determine the third",
            ));
        }
        let wall_nodes = match (surface, layers) {
            (Some(surface), _) => surface / 2,
            (None, Some(layers)) => n.unwrap_or(nodes) / (layers + 1),
            (None, None) => n.unwrap_or(nodes) / (usual_layers(n.unwrap_or(nodes)) + 1),
        };
        let nodes = match (n, layers) {
            (Some(n), _) => n,
            (None, Some(layers)) => wall_nodes * (layers + 1),
            (None, None) if surface.is_some() => wall_nodes * (usual_layers(nodes) + 1),
            (None, None) => nodes,
        };
        if wall_nodes < least_wall || nodes / wall_nodes < 5 {
            return Err(Error::input(format!(
                "{nodes} nodes give {wall_nodes} on the wall and {} layers of cells; at least {least_wall} and 4 are needed",
                (nodes / wall_nodes.max(1)).saturating_sub(1)
            )));
        }
        if nodes > MOST_NODES {
            return Err(Error::input(format!(
                "{nodes} nodes are too many; a sample has at most {MOST_NODES}"
            )));
        }
        Ok(Size {
            wall_nodes,
            layers,
            nodes,
            first_cell: self.first_cell.unwrap_or(FIRST_CELL),
        })
    }

    fn check_ranges(&self) -> Result<()> {
        let counts = [
            ("--nodes", self.nodes, MOST_NODES),
            ("--surface-nodes", self.surface_nodes, MOST_NODES),
            ("--layers", self.layers, 1000),
        ];
        for (option, value, most) in counts {
            if value.is_some_and(|value| value > most) {
                return Err(Error::input(format!("{option} is at most {most}")));
            }
        }
        if self.layers.is_some_and(|layers| layers < 4) {
            return Err(Error::input("--layers is at least 4"));
        }
        match self.first_cell {
            Some(height) if !(1e-9..=0.02).contains(&height) => Err(Error::input(format!(
                "--first-cell is a height in chords from 1e-9 to 0.02, found {height}"
            ))),
            _ => Ok(()),
        }
    }
}

impl Size {
    /// Layers of cells on a wall that came out with `wall_nodes` nodes.
    pub fn layers(&self, wall_nodes: usize) -> usize {
        let fitting = || (self.nodes as f64 / wall_nodes as f64).round() as usize;
        self.layers.unwrap_or_else(|| fitting().max(5) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_of_three_give_the_third() {
        let options = SizeOptions {
            nodes: Some(379_170),
            surface_nodes: Some(25_121),
            ..SizeOptions::default()
        };
        let size = options.resolve(60_000, |_| 40, 50).expect("it fits");
        assert_eq!((size.wall_nodes, size.layers(12_560)), (12_560, 29));
        let all = SizeOptions {
            layers: Some(3),
            ..options
        };
        assert!(all.resolve(60_000, |_| 40, 50).is_err());
    }

    #[test]
    fn too_few_nodes_are_refused_with_what_is_needed() {
        let options = SizeOptions {
            nodes: Some(60),
            ..SizeOptions::default()
        };
        let error = options.resolve(60_000, |_| 10, 50).expect_err("too few");
        assert!(error.to_string().contains("at least 50"), "{error}");
    }
}

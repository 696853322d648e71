//! Schedules made in memory. Nothing here fails: what is wrong is told when the schedule is resolved on a mesh.

use super::body::Body;
use super::boundaries::{Boundaries, Others, PeriodicPair};
use super::names::Pattern;
use super::options::{
    Interpolate, KernelName, Polynomial, RbfOptions, Refresh, SelectionCriterion, SelectionMethod,
    SelectionOptions,
};
use super::output::{OnInverted, OutputOptions, QualityOutput};
use super::places::Places;
use super::rotor::Rotor;
use super::schedule::Schedule;
use super::steps::Steps;
use crate::formats::{Compression, Encoding, Precision};
use crate::geometry::vector::Vector;
use std::path::PathBuf;

impl Schedule {
    /// Steps without a body yet; everything else is as in a file that leaves it out.
    pub fn new(steps: Steps) -> Self {
        Self {
            path: PathBuf::new(),
            steps,
            rotor: Rotor::default(),
            bodies: Vec::new(),
            boundaries: Boundaries::default(),
            rbf: RbfOptions::default(),
            selection: SelectionOptions::default(),
            output: OutputOptions::default(),
            places: Places::default(),
        }
    }

    /// The rotor.
    #[must_use]
    pub fn rotor(self, rotor: Rotor) -> Self {
        Self { rotor, ..self }
    }

    /// One more moving body; parents before their children.
    #[must_use]
    pub fn body(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// Zones that deform, and their interfaces to others stay fixed; all zones unless some are given.
    #[must_use]
    pub fn zones(mut self, zones: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let zones = Pattern::all(zones, &self.places, "boundaries.zones");
        self.boundaries.zones.extend(zones);
        self
    }

    /// Boundary tags that stay where they are. Here and below a tag may be a glob with `*` and `?`.
    #[must_use]
    pub fn fixed(mut self, tags: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let tags = Pattern::all(tags, &self.places, "boundaries.fixed");
        self.boundaries.fixed.extend(tags);
        self
    }

    /// Boundary tags whose nodes move along the boundary and never leave it.
    #[must_use]
    pub fn slide(mut self, tags: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let tags = Pattern::all(tags, &self.places, "boundaries.slide");
        self.boundaries.slide.extend(tags);
        self
    }

    /// Boundary tags whose nodes follow the interpolation like the inside of the mesh.
    #[must_use]
    pub fn free(mut self, tags: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let tags = Pattern::all(tags, &self.places, "boundaries.free");
        self.boundaries.free.extend(tags);
        self
    }

    /// A pair of boundary tags that are images of one another; their nodes move identically.
    #[must_use]
    pub fn periodic(mut self, a: impl Into<String>, b: impl Into<String>) -> Self {
        let key = "boundaries.periodic";
        let [a, b] = [a.into(), b.into()].map(|tag| Pattern::new(tag, &self.places, key));
        let place = self.places.of(key);
        self.boundaries.periodic.push(PeriodicPair { a, b, place });
        self
    }

    /// What boundary tags do that are not named anywhere; without it they are an error.
    #[must_use]
    pub fn others(mut self, others: Others) -> Self {
        self.boundaries.others = Some(others);
        self
    }

    /// The radial basis function; Wendland's C2 unless it is set.
    #[must_use]
    pub fn kernel(mut self, kernel: KernelName) -> Self {
        self.rbf.kernel = kernel;
        self
    }

    /// Support radius in mesh units; chosen by the program unless it is set.
    #[must_use]
    pub fn support_radius(mut self, radius: f64) -> Self {
        self.rbf.support_radius = Some(radius);
        self
    }

    /// What is added to the radial basis functions; nothing unless it is set.
    #[must_use]
    pub fn polynomial(mut self, polynomial: Polynomial) -> Self {
        self.rbf.polynomial = polynomial;
        self
    }

    /// What is interpolated: displacements unless it is set.
    #[must_use]
    pub fn interpolate(mut self, interpolate: Interpolate) -> Self {
        self.rbf.interpolate = interpolate;
        self
    }

    /// Support radius of the rotation alone, in mesh units; with [`Interpolate::Twist`].
    #[must_use]
    pub fn rotation_radius(mut self, radius: f64) -> Self {
        self.rbf.rotation_radius = Some(radius);
        self
    }

    /// Parts that each step is cut into; 1 unless it is set.
    #[must_use]
    pub fn substeps(mut self, substeps: usize) -> Self {
        self.rbf.substeps = substeps;
        self
    }

    /// How base points are chosen: for all steps at once unless it is set.
    #[must_use]
    pub fn method(mut self, method: SelectionMethod) -> Self {
        self.selection.method = method;
        self
    }

    /// Displacement error allowed on any surface node at any step, in mesh units; chosen by the program
    /// unless it is set.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.selection.tolerance = Some(tolerance);
        self
    }

    /// Which error of the surface nodes is to meet the tolerance; the largest unless it is set.
    #[must_use]
    pub fn criterion(mut self, criterion: SelectionCriterion) -> Self {
        self.selection.criterion = criterion;
        self
    }

    /// The displacement, in mesh units, that [`SelectionMethod::Constant`] chooses base points for; that of
    /// the motion unless it is set.
    #[must_use]
    pub fn constant(mut self, displacement: Vector) -> Self {
        self.selection.constant = Some(displacement);
        self
    }

    /// Base points at most; 5000 unless it is set.
    #[must_use]
    pub fn max_points(mut self, n: usize) -> Self {
        self.selection.max_points = n;
        self
    }

    /// Azimuth in degrees after which [`SelectionMethod::Real`] chooses anew; at every step unless it is set.
    #[must_use]
    pub fn refresh_deg(mut self, azimuth: f64) -> Self {
        self.selection.refresh = Some(Refresh {
            azimuth: azimuth.to_radians(),
            azimuth_deg: azimuth,
        });
        self
    }

    /// Whether surface nodes are put exactly where the motion takes them; they are unless it is set.
    #[must_use]
    pub fn correction(mut self, correction: bool) -> Self {
        self.selection.correction = correction;
        self
    }

    /// Name of the format that meshes are written in; `vtu` unless it is set.
    #[must_use]
    pub fn format(mut self, name: impl Into<String>) -> Self {
        self.output.format = name.into();
        self
    }

    /// Precision of the coordinates that are written; 64 bits unless it is set.
    #[must_use]
    pub fn precision(mut self, precision: Precision) -> Self {
        self.output.precision = precision;
        self
    }

    /// How much quality is worked out at each step; a row of steps.csv unless it is set.
    #[must_use]
    pub fn quality(mut self, quality: QualityOutput) -> Self {
        self.output.quality = quality;
        self
    }

    /// The displacement is written as a point array.
    #[must_use]
    pub fn displacement(mut self) -> Self {
        self.output.displacement = true;
        self
    }

    /// Node velocities are worked out, in mesh units a second, and written as a point array.
    #[must_use]
    pub fn velocity(mut self) -> Self {
        self.output.velocity = true;
        self
    }

    /// How numbers are stored in VTU files; raw unless it is set.
    #[must_use]
    pub fn encoding(mut self, encoding: Encoding) -> Self {
        self.output.encoding = encoding;
        self
    }

    /// Compression of binary data; none unless it is set.
    #[must_use]
    pub fn compression(mut self, compression: Compression) -> Self {
        self.output.compression = compression;
        self
    }

    /// What happens when a step has inverted cells; a warning unless it is set.
    #[must_use]
    pub fn on_inverted(mut self, on_inverted: OnInverted) -> Self {
        self.output.on_inverted = on_inverted;
        self
    }
}

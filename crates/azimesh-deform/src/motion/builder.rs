//! Schedules made in memory. Nothing here fails: errors come when the schedule is resolved on a mesh.

use super::body::Body;
use super::boundaries::{Boundaries, Others, PeriodicPair};
use super::names::Pattern;
use super::options::{
    Interpolate, KernelName, Polynomial, RbfOptions, Refresh, SelectionCriterion, SelectionMethod,
    SelectionOptions,
};
use super::output::{OnInverted, OutputOptions, QualityOutput, SurfaceOutput};
use super::places::Places;
use super::rotor::Rotor;
use super::schedule::Schedule;
use super::setters::setters;
use super::steps::Steps;
use azimesh_core::geometry::vector::Vector;
use azimesh_io::formats::{Compression, Encoding, Precision};
use std::path::PathBuf;

impl Schedule {
    /// Steps without a body yet; everything else is as in a file that leaves it out.
    pub fn new(steps: Steps) -> Self {
        Self {
            path: PathBuf::new(),
            text: String::new(),
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

    /// A pair of boundary tags that are images of one another; their nodes move identically.
    #[must_use]
    pub fn periodic(mut self, a: impl Into<String>, b: impl Into<String>) -> Self {
        let key = "boundaries.periodic";
        let [a, b] = [a.into(), b.into()].map(|tag| Pattern::new(tag, &self.places, key));
        let place = self.places.of(key);
        self.boundaries.periodic.push(PeriodicPair { a, b, place });
        self
    }
}

setters! { Schedule {
    /// The rotor.
    rotor(rotor: Rotor) |self| self.rotor = rotor;
    /// One more moving body; parents before their children.
    body(body: Body) |self| self.bodies.push(body);
    /// Zones that deform, and their interfaces to others stay fixed; all zones unless some are given.
    zones(zones: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.zones.extend(Pattern::all(zones, &self.places, "boundaries.zones"));
    /// Boundary tags that stay where they are. Here and below a tag may be a glob with `*` and `?`.
    fixed(tags: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.fixed.extend(Pattern::all(tags, &self.places, "boundaries.fixed"));
    /// Boundary tags whose nodes move along the boundary and never leave it.
    slide(tags: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.slide.extend(Pattern::all(tags, &self.places, "boundaries.slide"));
    /// Boundary tags whose nodes follow the interpolation like the inside of the mesh.
    free(tags: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.free.extend(Pattern::all(tags, &self.places, "boundaries.free"));
    /// What boundary tags do that are not named anywhere; without it they are an error.
    others(others: Others) |self| self.boundaries.others = Some(others);
    /// The radial basis function; Wendland's C2 unless it is set.
    kernel(kernel: KernelName) |self| self.rbf.kernel = kernel;
    /// Support radius in mesh units; chosen by the program unless it is set.
    support_radius(radius: f64) |self| self.rbf.support_radius = Some(radius);
    /// What is added to the radial basis functions; nothing unless it is set.
    polynomial(polynomial: Polynomial) |self| self.rbf.polynomial = polynomial;
    /// What is interpolated: displacements unless it is set.
    interpolate(interpolate: Interpolate) |self| self.rbf.interpolate = interpolate;
    /// Support radius of the rotation alone, in mesh units; with [`Interpolate::Twist`].
    rotation_radius(radius: f64) |self| self.rbf.rotation_radius = Some(radius);
    /// Parts that each step is cut into; 1 unless it is set.
    substeps(substeps: usize) |self| self.rbf.substeps = substeps;
    /// How base points are chosen: for all steps at once unless it is set.
    method(method: SelectionMethod) |self| self.selection.method = method;
    /// Displacement error allowed on any surface node at any step, in mesh units; chosen by the program
    /// unless it is set.
    tolerance(tolerance: f64) |self| self.selection.tolerance = Some(tolerance);
    /// Which error of the surface nodes is to meet the tolerance; the largest unless it is set.
    criterion(criterion: SelectionCriterion) |self| self.selection.criterion = criterion;
    /// The displacement, in mesh units, that [`SelectionMethod::Constant`] chooses base points for; that of
    /// the motion unless it is set.
    constant(displacement: Vector) |self| self.selection.constant = Some(displacement);
    /// Base points at most; 5000 unless it is set.
    max_points(n: usize) |self| self.selection.max_points = n;
    /// Azimuth in degrees after which [`SelectionMethod::Real`] chooses anew; at every step unless it is set.
    refresh_deg(azimuth_deg: f64) |self| self.selection.refresh = Some(Refresh { azimuth: azimuth_deg.to_radians(), azimuth_deg });
    /// True if surface nodes are put exactly where the motion takes them; they are unless it is set.
    correction(correction: bool) |self| self.selection.correction = correction;
    /// Name of the format that meshes are written in; unless it is set `vtu`, or `openfoam` for the mesh of a case.
    format(name: impl Into<String>) |self| self.output.format = Some(name.into());
    /// Precision of the coordinates that are written; 64 bits unless it is set.
    precision(precision: Precision) |self| self.output.precision = precision;
    /// How much quality is computed at each step; a row of steps.csv unless it is set.
    quality(quality: QualityOutput) |self| self.output.quality = quality;
    /// The displacement is written as a point array.
    displacement() |self| self.output.displacement = true;
    /// Node velocities are computed, in mesh units a second, and written as a point array.
    velocity() |self| self.output.velocity = true;
    /// How numbers are stored in VTU files; raw unless it is set.
    encoding(encoding: Encoding) |self| self.output.encoding = encoding;
    /// Compression of binary data; none unless it is set.
    compression(compression: Compression) |self| self.output.compression = compression;
    /// What happens when a step has inverted cells; a warning unless it is set.
    on_inverted(on_inverted: OnInverted) |self| self.output.on_inverted = on_inverted;
    /// Files of the moving surfaces, beside the meshes; none unless it is set.
    surface(surface: SurfaceOutput) |self| self.output.surface = surface;
    /// Title of the report; the name of the mesh unless it is set.
    title(title: impl Into<String>) |self| self.output.title = Some(title.into());
    /// What the mesh unit is called, such as `m`: lengths of tables in other units are converted to it, and the report names it.
    length_unit(unit: impl Into<String>) |self| self.output.length_unit = Some(unit.into());
} }

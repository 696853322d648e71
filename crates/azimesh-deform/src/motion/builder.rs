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
    /// Creates a schedule of these steps, without a body; all other options have their defaults.
    pub fn new(steps: Steps) -> Self {
        Self {
            path: PathBuf::new(),
            text: String::new(),
            steps,
            rotors: vec![Rotor::default()],
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
    /// Sets the rotor, or adds one of several, each with a [name](Rotor::name). The azimuth of the steps is that of the first.
    rotor(rotor: Rotor) |self| {
        self.rotors.retain(|other| other.name.is_some());
        self.rotors.push(rotor);
    };
    /// Adds a moving body; parents come before their children.
    body(body: Body) |self| self.bodies.push(body);
    /// Selects zones that deform; their interfaces to other zones stay fixed. All zones deform by default.
    zones(zones: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.zones.extend(Pattern::all(zones, &self.places, "boundaries.zones"));
    /// Boundary tags that stay where they are. Here and below a tag may be a glob with `*` and `?`.
    fixed(tags: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.fixed.extend(Pattern::all(tags, &self.places, "boundaries.fixed"));
    /// Boundary tags whose nodes move along the boundary and never leave it.
    slide(tags: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.slide.extend(Pattern::all(tags, &self.places, "boundaries.slide"));
    /// Boundary tags whose nodes follow the interpolation like the inside of the mesh.
    free(tags: impl IntoIterator<Item = impl Into<String>>) |self| self.boundaries.free.extend(Pattern::all(tags, &self.places, "boundaries.free"));
    /// Sets the treatment of boundary tags that the schedule does not name; without it they are an error.
    others(others: Others) |self| self.boundaries.others = Some(others);
    /// Sets the radial basis function; Wendland's C2 by default.
    kernel(kernel: KernelName) |self| self.rbf.kernel = kernel;
    /// Sets the support radius in mesh units; chosen by the program by default.
    support_radius(radius: f64) |self| self.rbf.support_radius = Some(radius);
    /// Sets the polynomial added to the radial basis functions; none by default.
    polynomial(polynomial: Polynomial) |self| self.rbf.polynomial = polynomial;
    /// Sets the quantity that is interpolated; displacements by default.
    interpolate(interpolate: Interpolate) |self| self.rbf.interpolate = interpolate;
    /// Sets the support radius of the rotation only, in mesh units; with [`Interpolate::Twist`].
    rotation_radius(radius: f64) |self| self.rbf.rotation_radius = Some(radius);
    /// Sets the number of substeps of each step; 1 by default.
    substeps(substeps: usize) |self| self.rbf.substeps = substeps;
    /// Sets the method that selects base points; by default one set for all steps.
    method(method: SelectionMethod) |self| self.selection.method = method;
    /// Sets the displacement error allowed at any surface node and step, in mesh units; chosen by the program by
    /// default.
    tolerance(tolerance: f64) |self| self.selection.tolerance = Some(tolerance);
    /// Sets the error norm of the surface nodes that must meet the tolerance; the largest error by default.
    criterion(criterion: SelectionCriterion) |self| self.selection.criterion = criterion;
    /// Sets the displacement, in mesh units, for which [`SelectionMethod::Constant`] selects base points; by default
    /// the displacement of the motion.
    constant(displacement: Vector) |self| self.selection.constant = Some(displacement);
    /// Sets the largest number of base points; 5000 by default.
    max_points(n: usize) |self| self.selection.max_points = n;
    /// Sets the azimuth interval in degrees after which [`SelectionMethod::Real`] selects again; every step by default.
    refresh_deg(azimuth_deg: f64) |self| self.selection.refresh = Some(Refresh { azimuth: azimuth_deg.to_radians(), azimuth_deg });
    /// Sets whether surface nodes are put exactly where the motion takes them; true by default.
    correction(correction: bool) |self| self.selection.correction = correction;
    /// Sets the format of the meshes; by default `vtu`, or `openfoam` for the mesh of a case.
    format(name: impl Into<String>) |self| self.output.format = Some(name.into());
    /// Sets the precision of written coordinates; 64 bits by default.
    precision(precision: Precision) |self| self.output.precision = precision;
    /// Sets the amount of quality output per step; a row of steps.csv by default.
    quality(quality: QualityOutput) |self| self.output.quality = quality;
    /// Writes the displacement as a point array.
    displacement() |self| self.output.displacement = true;
    /// Computes node velocities, in mesh units per second, and writes them as a point array.
    velocity() |self| self.output.velocity = true;
    /// Sets the encoding of numbers in VTU files; raw by default.
    encoding(encoding: Encoding) |self| self.output.encoding = encoding;
    /// Sets the compression of binary data; none by default.
    compression(compression: Compression) |self| self.output.compression = compression;
    /// Sets the reaction to inverted cells; a warning by default.
    on_inverted(on_inverted: OnInverted) |self| self.output.on_inverted = on_inverted;
    /// Sets the scaled Jacobian below which cells of a step are improved; none by default.
    improve(wanted: f64) |self| self.output.improve = Some(wanted);
    /// Sets the files of the moving surfaces, written alongside the meshes; none by default.
    surface(surface: SurfaceOutput) |self| self.output.surface = surface;
    /// Sets the title of the report; by default the name of the mesh.
    title(title: impl Into<String>) |self| self.output.title = Some(title.into());
    /// Sets the name of the mesh unit, such as `m`. Lengths of tables in other units are converted to it; the report names it.
    length_unit(unit: impl Into<String>) |self| self.output.length_unit = Some(unit.into());
} }

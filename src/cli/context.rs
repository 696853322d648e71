//! The context of every command: the common options, printing, threads and stages of work.

use super::{Common, threads};
use crate::alloc::spill;
use crate::preflight::existing_folder;
use crate::record::{Diagnostic, Failed, Level};
use azimesh_core::Note;
use azimesh_core::error::{Error, Result, is_unseen, lines, one_line};
use azimesh_core::numbers::amount;
use azimesh_core::parallel;
use azimesh_core::ranks::Ranks;
use azimesh_deform::Plan;
use azimesh_deform::motion::Schedule;
use azimesh_io::mesh::Mesh;
use serde::{Serialize, Serializer};
use std::cell::{Cell, RefCell};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// The common options, and printing: results to stdout, everything else to stderr.
pub struct Context {
    /// The common options.
    pub common: Common,
    /// The ranks; the first prints for all.
    pub ranks: Ranks,
    /// The command line without the program.
    pub arguments: Vec<String>,
    /// Ranks on this machine, which share its processors.
    n_on_node: usize,
    /// Notes and warnings, for JSON; also those that are not printed.
    told: RefCell<Vec<Diagnostic>>,
    /// Errors that were printed, for JSON.
    errors: RefCell<Vec<Failed>>,
    /// True if JSON has been printed.
    is_json_printed: Cell<bool>,
}

impl Context {
    /// Creates the context from the common options, for one process.
    pub fn new(common: Common) -> Self {
        Self {
            common,
            ranks: Ranks::alone(),
            arguments: Vec::new(),
            n_on_node: 1,
            told: RefCell::default(),
            errors: RefCell::default(),
            is_json_printed: Cell::default(),
        }
    }

    /// Makes it one of several ranks. `n_on_node` ranks are on this machine.
    pub fn on_ranks(self, ranks: &Ranks, n_on_node: usize) -> Self {
        Self {
            ranks: ranks.clone(),
            n_on_node,
            ..self
        }
    }

    /// Starts as many threads as requested or granted.
    pub fn start_threads(&self) -> Result<()> {
        let (n, by) = threads::granted(self.common.threads, self.n_on_node);
        self.detail(&format!("threads: {n} ({by})"));
        parallel::start(n)
    }

    /// Plans a schedule on the mesh in a file; also returns the mesh.
    pub fn plan(&self, path: &Path, schedule: Schedule) -> Result<(Plan, Arc<Mesh>)> {
        let mesh = self.read_mesh(path)?;
        let (plan, part) = Plan::new(mesh, schedule).map_err(|error| error.file(path))?;
        Ok((plan, part.mesh))
    }

    /// Runs `work` with a spinner on a terminal; with `-v` it prints the seconds.
    pub fn stage<T>(&self, name: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
        self.ranks.set_label(name);
        let progress = self.progress();
        progress.start(name, None);
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        progress.finish();
        self.detail(&format!("{name}: {seconds:.4} s"));
        result
    }

    /// Stores large arrays in files next to the output once half of `--max-memory` is in use; the other half is for arrays in
    /// use. Returns whether this is possible.
    pub fn keep_in_files(&self, output: &Path) -> bool {
        let limit = self.common.max_memory;
        let limit = limit.filter(|_| output.as_os_str() != "-");
        limit.is_some_and(|limit| spill::begin(&existing_folder(output), limit / 2, limit))
    }

    /// Prints with `-v` the largest size of arrays in files.
    pub fn tell_of_files(&self) {
        match spill::most_in_files() {
            0 => {}
            most => self.detail(&format!("in files at most: {}", amount(most))),
        }
    }

    /// Refuses a mesh and JSON together on standard output.
    pub fn check_json_beside(&self, output: &Path) -> Result<()> {
        if self.common.json && output.as_os_str() == "-" {
            Err(Error::input(
                "--json and a mesh cannot both go to standard output; write the mesh to a file",
            ))
        } else {
            Ok(())
        }
    }

    /// Prints the result of a command, unless quiet; the exit code remains.
    pub fn print_result(&self, text: &str) -> Result<()> {
        if self.common.quiet {
            Ok(())
        } else {
            self.print(&lines(text))
        }
    }

    /// Prints the result of a command to stderr, unless quiet, for a mesh on standard output.
    pub fn print_aside(&self, text: &str) {
        if !self.common.quiet {
            self.to_stderr(&lines(text.trim_end()));
        }
    }

    /// Prints to standard output. A closed pipe ends the output quietly.
    pub fn print(&self, text: &str) -> Result<()> {
        if !self.ranks.is_first() {
            return Ok(());
        }
        let mut out = std::io::stdout().lock();
        match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(Error::io(Path::new("<stdout>"), &error))
            }
            _ => Ok(()),
        }
    }

    /// Prints a JSON result with its version, and with the notes and warnings so far.
    pub fn print_json(&self, result: &impl Serialize) -> Result<()> {
        let value = serde_json::to_value(result);
        let mut value = value.expect("keys are text, and numbers that are not finite are null");
        if let Some(object) = value.as_object_mut() {
            object.shift_insert(0, "version".into(), 1.into());
            let told = serde_json::to_value(self.told.take());
            let told = told.expect("keys are text, and numbers that are not finite are null");
            object.insert("diagnostics".into(), told);
        }
        self.is_json_printed.set(true);
        self.print(&format!("{}\n", seen(&format!("{value:#}"))))
    }

    /// Adds a note to JSON and, unless quiet, prints it on stderr.
    pub fn note(&self, note: Note) {
        if !self.common.quiet {
            self.to_stderr(&format!("note: {}", one_line(&note.to_string())));
        }
        self.keep(Level::Note, &note);
    }

    /// Adds a warning to JSON and, unless quiet, prints it on stderr.
    pub fn warn(&self, note: Note) {
        if !self.common.quiet {
            self.print_warning(&one_line(&note.to_string()));
        }
        self.keep(Level::Warning, &note);
    }

    /// Adds a failed check to JSON and prints it on stderr, even if quiet.
    pub fn complain(&self, note: Note) {
        self.print_warning(&note.to_string());
        self.keep(Level::Warning, &note);
    }

    /// Adds a note to JSON only.
    pub fn keep(&self, level: Level, note: &Note) {
        self.told.borrow_mut().push(Diagnostic::new(level, note));
    }

    /// Prints a warning on stderr only.
    pub fn print_warning(&self, text: &str) {
        self.to_stderr(&format!("warning: {text}"));
    }

    /// Prints a detail on stderr with `-v`.
    pub fn detail(&self, text: &str) {
        if self.common.verbose > 0 {
            self.to_stderr(&one_line(text));
        }
    }

    /// Prints an error on stderr, always.
    pub fn error(&self, error: &Error) {
        self.to_stderr(&format!("error: {error}"));
        self.errors.borrow_mut().push(error.into());
    }

    /// Prints the error that ended the command as JSON, if JSON was requested and no result has been printed.
    pub fn print_json_of(&self, error: &Error) {
        if self.common.json && !self.is_json_printed.get() {
            let (error, errors) = (error.into(), self.errors.take());
            // The exit code belongs to the first error.
            let _ = self.print_json(&FailedCommand { error, errors });
        }
    }

    fn to_stderr(&self, text: &str) {
        if self.ranks.is_first() {
            // A closed stderr is ignored.
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }
}

/// A command that failed, with exit code 2 or 3, or that a signal ended.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FailedCommand {
    /// The error that ended the command.
    error: Failed,
    /// All errors that were printed, in order; empty where the arguments are wrong.
    errors: Vec<Failed>,
}

/// Entries of a JSON object whose keys are names, in their order.
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Entries<T>(
    #[cfg_attr(test, schemars(with = "std::collections::BTreeMap<String, T>"))] Vec<(String, T)>,
);

impl<K: Into<String>, T> FromIterator<(K, T)> for Entries<T> {
    fn from_iter<I: IntoIterator<Item = (K, T)>>(entries: I) -> Self {
        let entries = entries.into_iter().map(|(key, value)| (key.into(), value));
        Self(entries.collect())
    }
}

impl<T: Serialize> Serialize for Entries<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, value)| (key, value)))
    }
}

/// Escapes every control character in JSON: JSON itself requires that only for the first 32.
fn seen(json: &str) -> String {
    let mut seen = String::with_capacity(json.len());
    for c in json.chars() {
        if c != '\n' && is_unseen(c) {
            seen += &format!("\\u{:04x}", u32::from(c))
        } else {
            seen.push(c)
        }
    }
    seen
}

//! What every command needs: how to talk, how many threads, how to open a mesh.

use super::threads::Threads;
use super::{Common, heap};
use crate::error::{Error, Result, is_unseen, lines, one_line};
use crate::formats::{self, Format, Loaded, Location, ReadOptions};
use crate::mesh::Mesh;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// The common options, and printing: results to stdout, everything else to stderr.
pub struct Context {
    /// The common options as given.
    pub common: Common,
}

impl Context {
    /// From the common options.
    pub fn new(common: Common) -> Self {
        Self { common }
    }

    /// Runs `work` on as many threads as are asked for or granted.
    pub fn with_threads<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let Threads { n, by } = Threads::granted(self.common.threads);
        self.detail(&format!("threads: {n} ({by})"));
        rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build_global()
            .map_err(|error| Error::system(format!("cannot start {n} threads: {error}")))?;
        work()
    }

    /// Reads a mesh, in the format of `--format` where it is given.
    pub fn read_mesh(&self, path: &Path) -> Result<Mesh> {
        let Some(name) = &self.common.format else {
            return self.read_any(path);
        };
        let format = formats::by_name(name)?;
        let read = |location: &Location| formats::read_as(format, location, &self.read_options());
        self.load(path, read)
    }

    /// The format of `--format`, where it is given.
    pub fn input_format(&self) -> Result<Option<&'static dyn Format>> {
        let name = self.common.format.as_deref();
        name.map(formats::by_name).transpose()
    }

    /// Reads a mesh in the format that its content says, where `--format` is about the output.
    pub fn read_any(&self, path: &Path) -> Result<Mesh> {
        self.load(path, |location| {
            formats::read(location, &self.read_options())
        })
    }

    fn load(&self, path: &Path, read: impl FnOnce(&Location) -> Result<Loaded>) -> Result<Mesh> {
        let loaded = self.reading(path, || read(&self.open(path)?))?;
        for note in loaded.notes.iter() {
            self.note(&format!("{}: {note}", path.display()));
        }
        Ok(loaded.mesh)
    }

    /// Opens what is read; what it holds packed, or a pipe has, may take what `--max-memory` allows.
    pub fn open(&self, path: &Path) -> Result<Location> {
        heap::set_stage("reading", Some(path));
        Location::open_within(path, self.common.max_memory)
    }

    /// Reads, as a stage.
    pub fn reading<T>(&self, path: &Path, read: impl FnOnce() -> Result<T>) -> Result<T> {
        self.stage("reading", || {
            heap::set_stage("reading", Some(path));
            read()
        })
    }

    /// Does `work` under a spinner on a terminal; with `-v` its seconds are told.
    pub fn stage<T>(&self, name: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let progress = self.progress();
        progress.start(name, None);
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        progress.finish();
        self.detail(&format!("{name}: {seconds:.4} s"));
        result
    }

    /// Refuses a mesh on standard output beside JSON.
    pub fn check_json_beside(&self, output: &Path) -> Result<()> {
        match self.common.json && output.as_os_str() == "-" {
            true => Err(Error::input(
                "--json and a mesh cannot share standard output; write the mesh to a file",
            )),
            false => Ok(()),
        }
    }

    /// What readers are told.
    pub fn read_options(&self) -> ReadOptions {
        ReadOptions {
            tag_array: self.common.tag_array.clone(),
            step: None,
        }
    }

    /// Prints what a command found, unless quiet: then the exit code tells.
    pub fn print_result(&self, text: &str) -> Result<()> {
        match self.common.quiet {
            true => Ok(()),
            false => self.print(&lines(text)),
        }
    }

    /// The same to stderr, where a mesh goes to standard output.
    pub fn print_aside(&self, text: &str) {
        if !self.common.quiet {
            to_stderr(&lines(text.trim_end()));
        }
    }

    /// Prints to standard output. A closed pipe ends the output quietly.
    pub fn print(&self, text: &str) -> Result<()> {
        let mut out = std::io::stdout().lock();
        match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(Error::io(Path::new("<stdout>"), &error))
            }
            _ => Ok(()),
        }
    }

    /// Prints a JSON result with its version.
    pub fn print_json(&self, mut value: serde_json::Value) -> Result<()> {
        if let Some(object) = value.as_object_mut() {
            object.shift_insert(0, "version".into(), 1.into());
        }
        self.print(&format!("{}\n", seen(&format!("{value:#}"))))
    }

    /// A remark on stderr, unless quiet.
    pub fn note(&self, text: &str) {
        if !self.common.quiet {
            to_stderr(&format!("note: {}", one_line(text)));
        }
    }

    /// A warning on stderr, unless quiet.
    pub fn warn(&self, text: &str) {
        if !self.common.quiet {
            to_stderr(&format!("warning: {}", one_line(text)));
        }
    }

    /// Why a check failed, on stderr, always: the exit code alone does not tell.
    pub fn complain(&self, text: &str) {
        to_stderr(&format!("warning: {text}"));
    }

    /// A remark on stderr for those who asked for more with `-v`.
    pub fn detail(&self, text: &str) {
        if self.common.verbose > 0 {
            to_stderr(&one_line(text));
        }
    }

    /// An error on stderr, always.
    pub fn error(&self, error: &Error) {
        to_stderr(&format!("error: {error}"));
    }
}

/// JSON whose every control character stands as an escape: JSON itself wants that of the first 32 only.
fn seen(json: &str) -> String {
    let mut seen = String::with_capacity(json.len());
    for c in json.chars() {
        match c != '\n' && is_unseen(c) {
            true => seen += &format!("\\u{:04x}", u32::from(c)),
            false => seen.push(c),
        }
    }
    seen
}

fn to_stderr(text: &str) {
    // Nobody is left to tell when stderr is gone.
    let _ = writeln!(std::io::stderr(), "{text}");
}

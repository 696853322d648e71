//! Runs of schedules and formats that no file can name.

mod functions;
mod surface;
mod times;

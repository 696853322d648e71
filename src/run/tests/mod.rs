//! Runs of schedules and formats that no file can name.

mod folder_format;
mod functions;
mod surface;
mod times;

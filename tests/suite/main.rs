//! The library and the program from outside, as one program of tests: a module a subject.

#![allow(clippy::unwrap_used, clippy::print_stderr)] // what is skipped is told

mod adf;
#[cfg(target_os = "linux")]
mod arrays_in_files;
mod bad_input;
#[cfg(unix)]
mod batch_scripts;
#[cfg(target_os = "linux")]
mod bounded_memory;
mod choices;
mod comfort;
mod convert;
mod convert_sequences;
mod copies;
mod diff;
mod exit_codes;
mod exodus;
mod extend;
mod files_by_slabs;
mod finish;
mod fluent;
mod format_pairs;
mod inertial;
mod inputs;
mod layering;
mod manners;
#[cfg(target_os = "linux")]
mod memory;
mod mesh_commands;
mod names;
mod openfoam;
mod parts;
mod periodic;
#[cfg(unix)]
mod pipelines;
mod plot3d;
mod ranks;
mod real_meshes;
mod real_msh_su2;
mod records;
mod refusals;
mod repair;
mod repair_command;
mod report;
mod resume;
mod same_bytes;
mod selection;
mod shells;
mod slabs;
mod sliding;
mod space;
#[cfg(unix)]
mod special_files;
mod streams;
mod support;
mod surfaces;
mod system;
mod table_forms;
mod told;
mod twist;
mod vtk_files;
mod windows;

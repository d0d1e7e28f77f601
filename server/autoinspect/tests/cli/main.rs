//! Tests of the program from outside: processes, exit codes, files, signals.

mod actions;
mod changes;
mod core_process;
mod crash;
mod example;
mod failures;
mod fake_gateway;
mod gauges;
mod import;
mod interrupted_sessions;
mod localise;
mod managed_maps;
mod merge;
mod missions;
mod offline;
mod operator;
mod optimise;
mod patch;
mod platform;
mod program;
mod recordings;
mod refusals;
mod robot_process;
mod site_edits;
mod stored_data;
mod topomap;

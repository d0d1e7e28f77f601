//! Reports for people who do not use the client: of a run, and of all runs in a time. Each is one HTML file that is saved, printed and passed on, with its pictures and
//! without scripts. It is made while it is sent; memory holds a page of results and a piece of a file.

mod attention;
mod compared;
mod context;
mod file_view;
mod files;
mod findings;
mod format;
pub(crate) mod handlers;
mod head;
mod html;
mod page;
mod period_report;
mod results;
mod rows;
mod run_report;
mod spectrum;
mod table;
mod tasks;
#[cfg(test)]
mod tests;
mod texts;

//! The program at the command line.

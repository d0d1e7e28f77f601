//! The command line: its commands and the modules that run them.

use crate::failure::Failure;
use crate::{
    account, align, changes, convert, example, export, gauge, import, info, localise, make_normal, map,
    merge, optimise, patch, picture_changes, replay, sim_record, site, site_changes, topomap, trajectory, up,
    verify,
};
use clap::{Parser, Subcommand};

/// Mapping and inspection for robots in industrial sites.
#[derive(Parser, Debug)]
#[command(
    version,
    about,
    max_term_width = 110,
    after_help = "EXAMPLES:
  autoinspect up --demo --robot sim:b1       simulate a robot in a test hall and open http://127.0.0.1:8080
  autoinspect map recording.mcap --out m     make a map from a recording
  autoinspect info recording.mcap            say what a recording holds and lacks

EXIT CODES:
  0 done, 1 failed, 2 bad usage or unreadable input"
)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Run the platform: a robot's core and the server for browsers.
    Up(up::UpArgs),
    /// Accounts of people and tokens of programs, on the robot's own console.
    Account(account::AccountArgs),
    /// Check that the ledger is whole and its audit log unchanged.
    Verify(verify::VerifyArgs),
    /// Make a map from recordings or folders of scans.
    Map(map::MapArgs),
    /// Localise a recorded robot in a known map.
    Localise(localise::LocaliseArgs),
    /// Join maps of one site: of several walks, or of a part that was built later.
    Merge(merge::MergeArgs),
    /// Make a new version of a map with the changes that later recordings show.
    Patch(patch::PatchArgs),
    /// Make a new version of a map in which changes are normal.
    MakeNormal(make_normal::MakeNormalArgs),
    /// Write a saved map as one file for other programs, or as a picture from above.
    Export(export::ExportArgs),
    /// Make a map of another program's point cloud, for a robot to localise in.
    Import(import::ImportArgs),
    /// Give a saved map the frame of another one of the same site.
    Align(align::AlignArgs),
    /// Find the objects that appeared, were removed or moved between two visits.
    Changes(changes::ChangesArgs),
    /// Read the needle of a gauge from a picture.
    Gauge(gauge::GaugeArgs),
    /// Find what has changed between two pictures that were taken from nearly the same place.
    PictureChanges(picture_changes::PictureChangesArgs),
    /// Make a topological map, nodes and edges, from a saved map.
    Topomap(topomap::TopomapArgs),
    /// Make a site to try: map, topological map, inspection points, a mission and a schedule.
    Example(example::ExampleArgs),
    /// Find the best poses for a pose graph.
    Optimise(optimise::OptimiseArgs),
    /// Describe a recording and its missing inputs, or a saved map.
    Info(info::InfoArgs),
    /// Write a recording as one MCAP file of ROS 2 messages, for other programs or in less space.
    Convert(convert::ConvertArgs),
    /// Use the simulator without the platform.
    #[command(subcommand)]
    Sim(SimCommand),
    /// Write simulated sites as files.
    #[command(subcommand)]
    Site(SiteCommand),
    /// Evaluate trajectories.
    #[command(subcommand)]
    Trajectory(TrajectoryCommand),
    /// Step the stack through a journal and print the fingerprint of all its effects.
    Replay(replay::ReplayArgs),
    /// The simulated robot, which the core reaches by a socket; started by `up`.
    #[command(hide = true)]
    SimulatedRobot(up::SimulatedRobotArgs),
    /// The robot's core; started by `up`.
    #[command(hide = true)]
    Core(up::CoreArgs),
    /// The server for browsers; started by `up`.
    #[command(hide = true)]
    Gateway(up::GatewayArgs),
}

#[derive(Subcommand, Debug)]
enum SimCommand {
    /// Let the simulated robot walk a route, and record its sensors.
    Record(sim_record::RecordArgs),
    /// List what can change at a simulated site: doors, gauges and lamps.
    List(site_changes::ListArgs),
}

#[derive(Subcommand, Debug)]
enum SiteCommand {
    /// Write a site as a glTF building, to look at, or as an example of one's own.
    Export(site::SiteExportArgs),
}

#[derive(Subcommand, Debug)]
enum TrajectoryCommand {
    /// Compare an estimated trajectory with the ground truth.
    Compare(trajectory::CompareArgs),
}

impl Cli {
    /// Runs the command.
    pub fn run(self) -> Result<(), Failure> {
        match self.command {
            Command::Up(args) => up::run(&args),
            Command::Account(args) => account::run(&args),
            Command::Verify(args) => verify::run(&args),
            Command::Map(args) => map::run(&args),
            Command::Localise(args) => localise::run(&args),
            Command::Merge(args) => merge::run(&args),
            Command::Patch(args) => patch::run(&args),
            Command::MakeNormal(args) => make_normal::run(&args),
            Command::Export(args) => export::run(&args),
            Command::Import(args) => import::run(&args),
            Command::Align(args) => align::run(&args),
            Command::Changes(args) => changes::run(&args),
            Command::Gauge(args) => gauge::run(&args),
            Command::PictureChanges(args) => picture_changes::run(&args),
            Command::Topomap(args) => topomap::run(&args),
            Command::Example(args) => example::run(&args),
            Command::Optimise(args) => optimise::run(&args),
            Command::Info(args) => info::run(&args),
            Command::Convert(args) => convert::run(&args),
            Command::Sim(SimCommand::Record(args)) => sim_record::run(&args),
            Command::Sim(SimCommand::List(args)) => site_changes::list(&args),
            Command::Site(SiteCommand::Export(args)) => site::export(&args),
            Command::Trajectory(TrajectoryCommand::Compare(args)) => trajectory::run(&args),
            Command::Replay(args) => replay::run(&args),
            Command::SimulatedRobot(args) => up::run_robot(&args),
            Command::Core(args) => up::run_core(&args),
            Command::Gateway(args) => up::run_gateway(&args),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent_and_every_command_shows_an_example() {
        let command = Cli::command();
        command.clone().debug_assert();
        let mut waiting: Vec<_> = command.get_subcommands().cloned().collect();
        while let Some(command) = waiting.pop() {
            if command.has_subcommands() {
                waiting.extend(command.get_subcommands().cloned());
            } else if !command.is_hide_set() {
                let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
                assert!(help.contains("EXAMPLE"), "{} has no example", command.get_name());
            }
        }
    }
}

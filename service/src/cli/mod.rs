//! The command line: one file for each command. Standard output holds the chosen format and nothing
//! else; everything for people goes to standard error.

mod arguments;
mod bars;
mod check;
mod convert;
mod demo;
mod edit;
mod health;
mod interrupt;
mod openapi;
mod outcome;
mod replace;
mod serve;
mod text;
mod tradeoff;
mod version;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

pub use bars::bar;
pub use outcome::Outcome;
pub use text::before_and_after;

#[derive(Parser)]
#[command(
    name = "meshcolor",
    version,
    about = "Converts UV-textured meshes to mesh color textures, which have no seams",
    after_help = "Exit codes: 0 fine, 1 findings, 2 usage, 3 input refused, 4 operation failed; 130 and 143 on signals."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Serve the HTTP API
    Serve(serve::Arguments),
    /// Convert a model into a bundle
    Convert(convert::Arguments),
    /// Measure the seams of models, plain or converted
    Check(check::Arguments),
    /// Edit a model that has mesh colors: resolution, faces, subdivision, another mesh
    Edit(edit::Arguments),
    /// Convert a model by every rung and show what accuracy costs in time
    Tradeoff(tradeoff::Arguments),
    /// Show a conversion from end to end, through the HTTP service
    Demo(demo::Arguments),
    /// Print the API's OpenAPI document
    Openapi,
    /// Ask a running service whether it is ready
    Health(health::Arguments),
    /// Print the versions
    Version,
}

/// Runs the command that the arguments name.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors and go to standard output.
            let _ = error.print();
            return if error.use_stderr() { Outcome::Usage.into() } else { Outcome::Fine.into() };
        }
    };
    let outcome = match cli.command {
        Command::Serve(arguments) => serve::run(arguments),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Edit(arguments) => edit::run(&arguments),
        Command::Tradeoff(arguments) => tradeoff::run(&arguments),
        Command::Demo(arguments) => demo::run(arguments),
        Command::Openapi => openapi::run(),
        Command::Health(arguments) => health::run(&arguments),
        Command::Version => version::run(),
    };
    outcome.unwrap_or_else(|error| Outcome::of_error(&error)).into()
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_flag_has_its_variable() {
        for command in Cli::command().get_subcommands() {
            for flag in command.get_arguments().filter(|a| a.get_long().is_some_and(|long| long != "help")) {
                let variable = crate::settings::variable(flag.get_long().unwrap());
                let found = flag.get_env().and_then(|env| env.to_str());
                assert_eq!(found, Some(variable.as_str()), "{} --{}", command.get_name(), flag.get_id());
            }
        }
    }
}

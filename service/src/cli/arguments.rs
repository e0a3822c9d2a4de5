//! Arguments that several commands share: the conversion's options, straight from `OPTIONS`, and how
//! much of the machine to use.

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use meshcolor::pipeline::{OPTIONS, OptionSpec, Options};

use super::outcome::UsageError;
use crate::settings::variable;
use crate::work::processor_count;

/// The conversion's options as flags: names and values, in the order of `OPTIONS`.
#[derive(Clone, Debug)]
pub struct ConversionFlags(Vec<(&'static str, String)>);

impl ConversionFlags {
    /// # Errors
    /// What is not allowed.
    pub fn options(&self) -> Result<Options, UsageError> {
        let mut options = Options::default();
        for (name, value) in &self.0 {
            options.set(name, value)?;
        }
        options.check()?;
        Ok(options)
    }
}

impl Args for ConversionFlags {
    fn augment_args(command: Command) -> Command {
        command.args(OPTIONS.iter().map(|spec| {
            let argument = Arg::new(spec.name);
            let switch =
                |argument: Arg| argument.num_args(0..=1).require_equals(true).default_missing_value("true");
            let argument = if spec.is_switch() { switch(argument) } else { argument };
            let argument = if spec.is_list { argument.action(ArgAction::Append) } else { argument };
            argument
                .long(spec.name)
                .env(variable(spec.name))
                .value_name(spec.value_name)
                .help(format!("{} [allowed: {}] [default: {}]", spec.doc, spec.allowed, default(spec)))
                .help_heading("Conversion")
        }))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ConversionFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = OPTIONS.iter().filter_map(|spec| {
            let values: Vec<_> = matches.get_many::<String>(spec.name)?.cloned().collect();
            Some((spec.name, values.join(",")))
        });
        Ok(Self(given.collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn default(spec: &OptionSpec) -> String {
    let by_quality = if spec.follows_quality { ", or as --quality" } else { "" };
    format!("{}{by_quality}", spec.default)
}

/// How much of the machine to use, and how much to say.
#[derive(Clone, Debug, clap::Args)]
pub struct RunFlags {
    /// Threads that convert; the result does not depend on them
    #[arg(long, env = "MESHCOLOR_THREADS", value_name = "COUNT", default_value_t = processor_count(), value_parser = thread_count)]
    pub threads: usize,
    /// Say nothing but errors
    #[arg(long, env = "MESHCOLOR_QUIET")]
    pub quiet: bool,
}

/// More threads than any machine has would only exhaust memory.
const MOST_THREADS: usize = 1024;

pub fn thread_count(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MOST_THREADS).contains(count));
    count.ok_or_else(|| format!("allowed: 1 to {MOST_THREADS}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_and_flags_reach_the_options() {
        let read = |arguments: &[&str]| {
            let command = ConversionFlags::augment_args(Command::new("x"));
            let matches = command.get_matches_from(["x"].iter().chain(arguments));
            ConversionFlags::from_arg_matches(&matches).unwrap().options()
        };
        assert_eq!(read(&[]).unwrap(), Options::default());
        let options = read(&["--cut", "3", "--solver=clamp"]).unwrap();
        assert_eq!(options.cut_codes, 3.0);
        assert!(read(&["--merge", "--cut", "3"]).unwrap().merges);
        assert!(!read(&["--no-share=false"]).unwrap().merges);
        let listed =
            read(&["--channel", "a=x.png", "--channel=b@Skin=y.exr#1", "--textures", "png,exr"]).unwrap();
        let json = listed.to_json();
        assert_eq!(json["channel"], "a=x.png,b@Skin=y.exr#1");
        assert_eq!(json["textures"], "png,exr");
        assert!(read(&["--cut", "many"]).unwrap_err().to_string().contains("0..=255"));
        assert!(read(&["--compress", "bc7"]).unwrap_err().to_string().contains("add ktx2"));
    }
}

//! Every limit of the service, defined once: name, default, unit, doc. Flags, `MESHCOLOR_*` variables
//! and error texts come from [`SETTINGS`]. Limits on models live in `meshcolor::read::Limits`, and the
//! command line shares them.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, value_parser};
use meshcolor::read::Limits;

#[derive(Clone, Debug)]
pub struct Settings {
    pub max_body_bytes: u64,
    pub max_part_header_bytes: u64,
    pub max_options_bytes: u64,
    pub header_read_timeout_seconds: u64,
    pub body_idle_timeout_seconds: u64,
    pub upload_timeout_seconds: u64,
    pub max_connections: u64,
    pub max_concurrent_uploads: u64,
    pub queue_max: u64,
    pub sync_timeout_seconds: u64,
    pub max_wait_seconds: u64,
    pub shutdown_grace_seconds: u64,
    pub limits: Limits,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_body_bytes: 256 << 20,
            max_part_header_bytes: 8 << 10,
            max_options_bytes: 64 << 10,
            header_read_timeout_seconds: 10,
            body_idle_timeout_seconds: 30,
            upload_timeout_seconds: 600,
            max_connections: 2048,
            max_concurrent_uploads: 64,
            queue_max: 1000,
            sync_timeout_seconds: 30,
            max_wait_seconds: 60,
            shutdown_grace_seconds: 30,
            limits: Limits::default(),
        }
    }
}

/// The figure behind a setting.
pub enum Figure<'a> {
    U32(&'a mut u32),
    U64(&'a mut u64),
}

/// One setting as every interface shows it.
pub struct SettingSpec {
    /// `--name`; the variable is `MESHCOLOR_NAME` in capitals.
    pub name: &'static str,
    pub value_name: &'static str,
    pub doc: &'static str,
    /// Whether it limits models (the command line has it too) or the service alone.
    pub is_about_models: bool,
    figure: fn(&mut Settings) -> Figure<'_>,
}

macro_rules! setting {
    ($name:literal, $unit:literal, $width:ident($($field:ident).+), $models:literal, $doc:literal) => {
        SettingSpec {
            name: $name,
            value_name: $unit,
            doc: $doc,
            is_about_models: $models,
            figure: |settings| Figure::$width(&mut settings.$($field).+),
        }
    };
}

pub const SETTINGS: &[SettingSpec] = &[
    setting!("max-body-bytes", "BYTES", U64(max_body_bytes), false, "Largest request body"),
    setting!(
        "max-part-header-bytes",
        "BYTES",
        U64(max_part_header_bytes),
        false,
        "Largest header of one multipart part"
    ),
    setting!("max-options-bytes", "BYTES", U64(max_options_bytes), false, "Largest options part"),
    setting!(
        "header-read-timeout",
        "SECONDS",
        U64(header_read_timeout_seconds),
        false,
        "Time for a request's header"
    ),
    setting!(
        "body-idle-timeout",
        "SECONDS",
        U64(body_idle_timeout_seconds),
        false,
        "Longest silence inside an upload"
    ),
    setting!("upload-timeout", "SECONDS", U64(upload_timeout_seconds), false, "Time for a whole upload"),
    setting!(
        "max-connections",
        "COUNT",
        U64(max_connections),
        false,
        "Connections at a time; more of them wait"
    ),
    setting!("max-concurrent-uploads", "COUNT", U64(max_concurrent_uploads), false, "Uploads at a time"),
    setting!("queue-max", "COUNT", U64(queue_max), false, "Jobs that may wait"),
    setting!(
        "sync-timeout",
        "SECONDS",
        U64(sync_timeout_seconds),
        false,
        "How long /v1/convert and /v1/check wait"
    ),
    setting!("max-wait", "SECONDS", U64(max_wait_seconds), false, "Longest `Prefer: wait`"),
    setting!(
        "shutdown-grace",
        "SECONDS",
        U64(shutdown_grace_seconds),
        false,
        "Time for running jobs when the service stops"
    ),
    setting!("max-files", "COUNT", U64(limits.files), true, "Files of one model"),
    setting!("archive-max-bytes", "BYTES", U64(limits.archive_bytes), true, "Unpacked bytes of an archive"),
    setting!(
        "archive-max-ratio",
        "FACTOR",
        U64(limits.archive_ratio),
        true,
        "Unpacked over packed bytes of an archive"
    ),
    setting!("archive-max-entries", "COUNT", U64(limits.archive_entries), true, "Entries of an archive"),
    setting!("max-image-side", "PIXELS", U32(limits.image_side), true, "Width or height of a source image"),
    setting!("max-image-pixels", "PIXELS", U64(limits.image_pixels), true, "Pixels of a source image"),
    setting!(
        "max-job-pixels",
        "PIXELS",
        U64(limits.job_pixels),
        true,
        "Pixels of all source images together"
    ),
    setting!("max-triangles", "COUNT", U64(limits.triangles), true, "Triangles of a model"),
    setting!("max-vertices", "COUNT", U64(limits.vertices), true, "Vertices of a model"),
    setting!("max-nodes", "COUNT", U64(limits.nodes), true, "Nodes of a model"),
    setting!("max-json-bytes", "BYTES", U64(limits.json_bytes), true, "Bytes of a model's JSON"),
    setting!("max-json-depth", "LEVELS", U32(limits.json_depth), true, "Depth of a model's JSON"),
    setting!(
        "max-texture-side",
        "PIXELS",
        U32(limits.texture_side),
        true,
        "Side of the largest texture that is written"
    ),
];

impl SettingSpec {
    pub fn variable(&self) -> String {
        variable(self.name)
    }

    pub fn value(&self, settings: &mut Settings) -> u64 {
        match (self.figure)(settings) {
            Figure::U32(figure) => u64::from(*figure),
            Figure::U64(figure) => *figure,
        }
    }

    fn arg(&self) -> Arg {
        let ceiling = match (self.figure)(&mut Settings::default()) {
            Figure::U32(_) => u64::from(u32::MAX),
            // One below the top, so that "limit + 1" needs no thought; also what SQLite can hold.
            Figure::U64(_) => i64::MAX as u64,
        };
        Arg::new(self.name)
            .long(self.name)
            .env(self.variable())
            .value_name(self.value_name)
            .value_parser(value_parser!(u64).range(1..=ceiling))
            .default_value(self.value(&mut Settings::default()).to_string())
            .help(self.doc)
            .help_heading("Limits")
            .hide_short_help(true)
    }
}

/// The environment variable that stands for a flag.
pub fn variable(flag: &str) -> String {
    format!("MESHCOLOR_{}", flag.replace('-', "_").to_uppercase())
}

/// Sentence that names the setting behind a model's limit, where a figure belongs to one.
pub fn raising_hint(limits: &Limits, code: meshcolor::ErrorCode, limit: u64) -> Option<String> {
    use meshcolor::ErrorCode as Code;
    let topics: &[&str] = match code {
        Code::ImageTooLarge => &["image", "pixels"],
        Code::TooManyTriangles => &["triangles"],
        Code::ModelTooLarge => &["vertices", "nodes", "json"],
        Code::ArchiveRatio | Code::ArchiveTooLarge => &["archive"],
        Code::TooManyFiles => &["files", "entries"],
        Code::TextureTooLarge => &["texture"],
        _ => return None,
    };
    let mut settings = Settings { limits: limits.clone(), ..Settings::default() };
    let spec = SETTINGS.iter().filter(|spec| spec.is_about_models).find(|spec| {
        topics.iter().any(|topic| spec.name.contains(topic)) && spec.value(&mut settings) == limit
    })?;
    Some(format!("Raise it with {}.", spec.variable()))
}

/// Flags of [`SETTINGS`]: all of them for the service, those about models for the command line.
fn augment(command: Command, models_only: bool) -> Command {
    command.args(SETTINGS.iter().filter(|s| s.is_about_models || !models_only).map(SettingSpec::arg))
}

fn from_matches(matches: &ArgMatches, models_only: bool) -> Settings {
    let mut settings = Settings::default();
    for spec in SETTINGS.iter().filter(|s| s.is_about_models || !models_only) {
        if let Some(&value) = matches.get_one::<u64>(spec.name) {
            match (spec.figure)(&mut settings) {
                Figure::U32(figure) => *figure = u32::try_from(value).unwrap_or(u32::MAX),
                Figure::U64(figure) => *figure = value,
            }
        }
    }
    settings
}

impl Args for Settings {
    fn augment_args(command: Command) -> Command {
        augment(command, false)
    }
    fn augment_args_for_update(command: Command) -> Command {
        augment(command, false)
    }
}

impl FromArgMatches for Settings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(from_matches(matches, false))
    }
    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = from_matches(matches, false);
        Ok(())
    }
}

/// The limits on models alone, as flags of `convert` and `check`.
#[derive(Clone, Debug)]
pub struct ModelLimits(pub Limits);

impl Args for ModelLimits {
    fn augment_args(command: Command) -> Command {
        augment(command, true)
    }
    fn augment_args_for_update(command: Command) -> Command {
        augment(command, true)
    }
}

impl FromArgMatches for ModelLimits {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(from_matches(matches, true).limits))
    }
    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0 = from_matches(matches, true).limits;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_reaches_its_own_figure() {
        let command = Settings::augment_args(Command::new("x"));
        for spec in SETTINGS {
            let matches = command.clone().get_matches_from(["x".to_owned(), format!("--{}=7", spec.name)]);
            let mut settings = from_matches(&matches, false);
            let mut untouched = Settings::default();
            for other in SETTINGS {
                let expected = if other.name == spec.name { 7 } else { other.value(&mut untouched) };
                assert_eq!(other.value(&mut settings), expected, "--{} and {}", spec.name, other.name);
            }
        }
    }

    #[test]
    fn hints_name_the_setting_that_was_met() {
        let limits = Limits::default();
        let hint = |code, limit| raising_hint(&limits, code, limit);
        use meshcolor::ErrorCode as Code;
        assert_eq!(
            hint(Code::ImageTooLarge, limits.image_pixels).as_deref(),
            Some("Raise it with MESHCOLOR_MAX_IMAGE_PIXELS.")
        );
        assert_eq!(
            hint(Code::ModelTooLarge, limits.nodes).as_deref(),
            Some("Raise it with MESHCOLOR_MAX_NODES.")
        );
        assert_eq!(hint(Code::InvalidModel, limits.nodes), None);
    }
}

//! What the documents say, held against the code: options, limits, routes, commands, paths, tables.

use std::collections::BTreeSet;

use meshcolor::pipeline::{OPTIONS, Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_service::settings::{SETTINGS, Settings, variable};
use meshcolor_tests::repository::{backticked, file, hold, markdown, root};

#[test]
fn the_readme_has_every_option() {
    let rows = OPTIONS.iter().map(|spec| {
        let cells = [format!("`--{}`", spec.name), format!("`{}`", spec.default)];
        cells.into_iter().chain([spec.doc.to_owned(), spec.allowed.to_owned()]).collect()
    });
    hold("README.md", "options", &markdown(&["option", "default", "what it does", "allowed"], rows));
}

#[test]
fn the_readme_has_every_limit() {
    let mut defaults = Settings::default();
    let rows = SETTINGS.iter().map(|spec| {
        let figure = shown(spec.value(&mut defaults), spec.value_name);
        vec![format!("`{}`", spec.variable()), figure, spec.doc.to_owned()]
    });
    hold("README.md", "limits", &markdown(&["setting", "default", "what it limits"], rows));
}

/// A default with its unit, as people read it.
fn shown(value: u64, unit: &str) -> String {
    let digits = value.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().map(|g| str::from_utf8(g).unwrap()).collect();
    let grouped = groups.join(" ");
    let binary = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    match (unit, binary.into_iter().find(|(bits, _)| value.trailing_zeros() >= *bits)) {
        ("BYTES", Some((bits, prefix))) => format!("{} {prefix}", value >> bits),
        ("COUNT", _) => grouped,
        ("FACTOR", _) => format!("{grouped} to 1"),
        (unit, _) => format!("{grouped} {}", unit.to_lowercase()),
    }
}

#[test]
fn the_readme_shows_an_error_as_it_is() {
    let upload = Upload::single("sample.glb", meshcolor_service::sample::model());
    let limits = Limits { image_pixels: 1000, ..Limits::default() };
    let Err(error) = convert(&upload, &Options::default(), &limits, &Unwatched) else {
        panic!("the sample has larger images");
    };
    hold("README.md", "error", &format!("```\nsample.glb: {error}\n```"));
}

#[test]
fn the_readme_shows_what_the_demo_prints() {
    let upload = Upload::single("sample.glb", meshcolor_service::sample::model());
    let conversion = convert(&upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
    let printed = meshcolor_service::cli::before_and_after(&conversion.report);
    hold("README.md", "demo", &format!("```\n{}\n```", printed.trim()));
}

#[test]
fn curl_lines_ask_for_paths_that_there_are() {
    let api = file("openapi.yaml");
    let paths: Vec<&str> =
        api.lines().filter_map(|line| line.strip_prefix("  /")?.strip_suffix(':')).collect();
    let mut asked = 0;
    for document in [
        "README.md",
        "docs/format.md",
        "docs/figures.md",
        "docs/tradeoff.md",
        "docs/ladders.md",
        "docs/solver.md",
    ] {
        let text = file(document);
        for url in text.split_whitespace().filter_map(|word| word.split_once("localhost:8080/")) {
            let path = url.1.trim_end_matches(['\'', '"', '`', ',', '.']).split('?').next().unwrap();
            let path = path.replace("$id", "{id}").replace("JOB", "{id}");
            assert!(paths.contains(&path.as_str()), "{document}: there is no route /{path}");
            asked += 1;
        }
    }
    assert!(asked >= 8, "only {asked} routes found");
}

/// The variables that mean something: those of the settings, of flags and of the log.
fn known_variables() -> BTreeSet<String> {
    let mut known: BTreeSet<String> = SETTINGS.iter().map(|spec| spec.variable()).collect();
    known.extend(OPTIONS.iter().map(|spec| variable(spec.name)));
    for source in std::fs::read_dir(root().join("service/src/cli")).unwrap() {
        let text = std::fs::read_to_string(source.unwrap().path()).unwrap();
        known.extend(
            text.split("env = \"").skip(1).filter_map(|rest| rest.split('"').next().map(str::to_owned)),
        );
    }
    assert!(file("service/src/logging.rs").contains("MESHCOLOR_LOG"));
    known.insert("MESHCOLOR_LOG".to_owned());
    known
}

fn variables_in(text: &str) -> BTreeSet<String> {
    let is_name = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    let after = text.split("MESHCOLOR_").skip(1);
    let names = after.map(|rest| rest.chars().take_while(|c| is_name(*c)).collect::<String>());
    // `MESHCOLOR_*` stands for all of them.
    names.filter(|name| !name.is_empty()).map(|name| format!("MESHCOLOR_{name}")).collect()
}

/// Each command has a file of its own.
fn is_command(name: &str) -> bool {
    root().join(format!("service/src/cli/{name}.rs")).is_file()
}

#[test]
fn named_variables_are_read_by_something() {
    // Read by the tests.
    let of_tests = ["MESHCOLOR_ASSETS", "MESHCOLOR_REQUIRE_TOOLS", "MESHCOLOR_WRITE_DOCS"];
    let known = known_variables();
    for document in [
        "README.md",
        "Dockerfile",
        "docs/figures.md",
        "docs/tradeoff.md",
        "docs/ladders.md",
        "docs/solver.md",
        "CHANGELOG.md",
    ] {
        let named = variables_in(&file(document));
        let unknown: Vec<_> = named
            .iter()
            .filter(|name| !known.contains(*name) && !of_tests.contains(&name.as_str()))
            .collect();
        assert!(unknown.is_empty(), "{document} names {unknown:?}, which nothing reads");
    }
}

#[test]
fn the_image_runs_what_there_is() {
    let dockerfile = file("Dockerfile");
    let mut commands = Vec::new();
    for line in dockerfile.lines() {
        let Some(start) = line.find('[') else { continue };
        let is_run =
            ["ENTRYPOINT", "CMD", "HEALTHCHECK"].iter().any(|word| line.trim_start().starts_with(word));
        if is_run {
            let words: Vec<String> = serde_json::from_str(&line[start..]).expect(line);
            commands.extend(words.into_iter().filter(|word| !word.starts_with(['/', '-'])));
        }
    }
    assert_eq!(commands, ["health", "serve"]);
    assert!(commands.iter().all(|name| is_command(name)));
    // The builder copies the packages of the workspace, by name.
    for member in ["core", "shaders", "service", "tests"] {
        let copied = format!("COPY {member}/ {member}/");
        assert!(dockerfile.contains(&copied), "the builder lacks `{copied}`");
    }
    let version = file("Cargo.toml");
    let rust = version.lines().find_map(|line| line.strip_prefix("rust-version = ")).unwrap();
    assert!(dockerfile.contains(&format!("FROM rust:{}-", rust.trim_matches('"'))));
}

#[test]
fn commands_in_the_readme_exist() {
    let readme = file("README.md");
    let words = readme.lines().filter_map(|line| line.trim_start().strip_prefix("meshcolor "));
    let named: BTreeSet<&str> = words.filter_map(|rest| rest.split_whitespace().next()).collect();
    let unknown: Vec<_> = named.iter().filter(|name| !is_command(name)).collect();
    assert!(unknown.is_empty(), "README.md names {unknown:?}");
    for command in ["serve", "convert", "check", "tradeoff", "demo", "openapi", "health", "version"] {
        assert!(named.contains(command), "README.md does not name {command}");
    }
}

/// Stands in every bundle, not in the repository.
const IN_BUNDLES: [&str; 2] = ["shaders/mesh_color_texture.wgsl", "shaders/mesh_color_texture_indexed.wgsl"];

#[test]
fn paths_in_documents_lead_somewhere() {
    let documents = [
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "docs/format.md",
        "docs/figures.md",
        "docs/tradeoff.md",
        "docs/ladders.md",
        "docs/solver.md",
    ];
    for document in documents {
        let text = file(document);
        let folder = root().join(document);
        let folder = folder.parent().unwrap();
        let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        let links = links.filter(|link| !link.contains("://") && !link.starts_with('#'));
        for link in links {
            let link = link.split('#').next().unwrap();
            assert!(folder.join(link).exists(), "{document} links to {link}");
        }
        let is_path = |word: &String| {
            let roots = ["core/", "shaders/", "service/", "tests/", "docs/", ".ci/"];
            roots.iter().any(|root| word.starts_with(root))
                && !word.contains(['…', '{', '*', ' '])
                && !IN_BUNDLES.contains(&word.as_str())
        };
        for path in backticked(&text).into_iter().filter(is_path) {
            assert!(root().join(&path).exists(), "{document} names {path}");
        }
    }
}

#[test]
fn the_changelog_knows_this_version() {
    let manifest = file("Cargo.toml");
    let version = manifest.lines().find_map(|line| line.strip_prefix("version = ")).unwrap();
    assert!(file("CHANGELOG.md").contains(&format!("## [{}]", version.trim_matches('"'))));
}

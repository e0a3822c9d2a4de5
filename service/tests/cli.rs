//! The command line from outside: what it prints where, and its exit codes.

mod support;

use std::fs;

use support::{Folder, Service, run};

#[test]
fn the_document_is_the_committed_one() {
    let printed = run(&["openapi"]);
    assert_eq!(printed.status.code(), Some(0));
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../openapi.yaml");
    let committed = fs::read_to_string(path).unwrap();
    let printed = String::from_utf8(printed.stdout).unwrap();
    assert!(printed == committed, "openapi.yaml is not what `meshcolor openapi` prints; write it anew");
}

#[test]
fn usage_errors_are_two_and_speak_on_standard_error() {
    let folder = Folder::new();
    let out = folder.path("out");
    let wrong: [&[&str]; 8] = [
        &[],
        &["convert", "a.glb"],
        &["convert", "a.glb", "-o", &out, "--solver", "magic"],
        &["convert", "a.glb", "-o", &out, "--threads", "0"],
        &["tradeoff", "a.glb"],
        &["tradeoff", "a.glb", "-o", &out, "--repeat", "0"],
        &["check"],
        &["serve", "--max-body-bytes", "many"],
    ];
    for arguments in wrong {
        let ended = run(arguments);
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}");
        assert!(ended.stdout.is_empty() && !ended.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn variables_stand_for_flags() {
    let ended = support::binary().args(["check", "a.glb"]).env("MESHCOLOR_SOLVER", "magic").output().unwrap();
    assert_eq!(ended.status.code(), Some(2));
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(said.contains("clamp, local, global"), "{said}");
}

#[test]
fn missing_models_are_refused_and_leave_nothing() {
    let folder = Folder::new();
    let (model, out) = (folder.path("none.glb"), folder.path("out"));
    for arguments in [&["convert", &model, "-o", &out][..], &["check", &model]] {
        let ended = run(arguments);
        assert_eq!(ended.status.code(), Some(3), "{arguments:?}");
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert!(said.contains("none.glb"), "{said}");
    }
    assert_eq!(fs::read_dir(folder.root()).unwrap().count(), 0);
}

#[test]
fn a_tradeoff_is_a_folder_and_json_on_demand() {
    let folder = Folder::new();
    let out = folder.path("cost");
    let arguments = ["tradeoff", "-o", &out, "--resolution", "fixed:0", "--json"];
    let ended = run(&arguments);
    assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
    let record = fs::read(format!("{out}/tradeoff.json")).unwrap();
    assert!(ended.stdout == record);
    let mut names: Vec<_> =
        fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let expected = ["curve.png", "curve.svg", "tradeoff.json", "tradeoff.md", "tradeoff.png", "tradeoff.svg"];
    assert_eq!(names, expected);
    assert_eq!(run(&arguments).status.code(), Some(2), "it replaces nothing unasked");
    assert_eq!(run(&[&arguments[..], &["--force", "--quiet"]].concat()).status.code(), Some(0));
}

#[test]
fn what_is_there_is_not_overwritten() {
    let folder = Folder::new();
    let (model, zip, thesis) = (folder.path("a.glb"), folder.path("out.zip"), folder.path("thesis"));
    fs::write(&model, support::model(1, 16)).unwrap();
    fs::write(&zip, "mine").unwrap();
    fs::create_dir(&thesis).unwrap();
    fs::write(folder.root().join("thesis/a.tex"), "mine").unwrap();
    for arguments in [&["-o", &zip][..], &["-o", &thesis], &["-o", &thesis, "--force"]] {
        let ended = run(&[&["convert", &model], arguments].concat());
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}");
    }
    assert_eq!(fs::read_to_string(&zip).unwrap(), "mine");
    assert_eq!(fs::read_to_string(folder.root().join("thesis/a.tex")).unwrap(), "mine");
    assert_eq!(fs::read_dir(folder.root()).unwrap().count(), 3);
}

#[test]
fn health_asks_the_service() {
    let data = Folder::new();
    let service = Service::start(data.root(), &[]);
    let healthy = run(&["health", "--bind", service.address()]);
    assert_eq!(healthy.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&healthy.stdout).contains("\"ready\":true"));
    let address = service.address().to_owned();
    service.kill();
    assert_eq!(run(&["health", "--bind", &address]).status.code(), Some(4));
}

#[test]
fn the_version_is_one_line() {
    let printed = run(&["version"]);
    let text = String::from_utf8(printed.stdout).unwrap();
    assert!(text.starts_with(&format!("meshcolor {}", env!("CARGO_PKG_VERSION"))), "{text}");
    assert_eq!(text.lines().count(), 1);
}

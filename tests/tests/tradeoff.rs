//! The records of `docs/tradeoff` and what is drawn and written from them. Times are what one machine gave
//! on one day, so nothing asks for them again; the sample's errors are computed anew, and every picture and
//! table is what its record says. `docs/tradeoff.sh` makes the records.

use std::fs;

use meshcolor::pipeline::{Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_service::tradeoff::{
    self, End, Errors, HOME, Plan, PointEnd, Tradeoff, UnitErrors, curve_headline, figure, headline,
    runs_table, time,
};
use meshcolor_service::{plot, scaling};
use meshcolor_tests::repository::{file, hold, markdown, root, writes_documents};

const MODELS: [&str; 3] = ["sample", "spot_control_mesh", "DamagedHelmet"];
/// Whose curves of texels against error `docs/storage.md` shows.
const CURVES: [&str; 5] = ["DamagedHelmet", "Fox", "sample", "spot_control_mesh", "spot_fine"];
/// Another processor's arithmetic may move the last digits.
const TOLERANCE: f64 = 1e-3;
/// What it may change in a picture: mean and largest difference of a pixel, codes.
const PICTURE_CODES: [f64; 2] = [0.01, 40.0];

fn record(model: &str) -> Tradeoff {
    serde_json::from_str(&file(&format!("docs/tradeoff/{model}.json"))).unwrap()
}

/// Holds `docs/NAME.svg` and `.png` against the picture.
fn hold_picture(name: &str, svg: &str) {
    let path = |ending: &str| root().join(format!("docs/{name}.{ending}"));
    let png = plot::png(svg).unwrap();
    if writes_documents() {
        fs::write(path("svg"), svg).unwrap();
        fs::write(path("png"), png).unwrap();
        return;
    }
    let stale = "is not what its record says; MESHCOLOR_WRITE_DOCS=1 draws it anew";
    assert!(fs::read_to_string(path("svg")).unwrap() == svg, "docs/{name}.svg {stale}");
    let [there, now] =
        [fs::read(path("png")).unwrap(), png].map(|bytes| image::load_from_memory(&bytes).unwrap().to_rgb8());
    assert_eq!(there.dimensions(), now.dimensions(), "docs/{name}.png {stale}");
    let differences = || there.as_raw().iter().zip(now.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b)));
    let mean = differences().sum::<f64>() / there.as_raw().len() as f64;
    let most = differences().fold(0.0, f64::max);
    assert!(mean <= PICTURE_CODES[0] && most <= PICTURE_CODES[1], "docs/{name}.png {stale}: {mean}, {most}");
}

#[test]
fn pictures_and_tables_are_what_the_records_say() {
    for model in MODELS {
        let record = record(model);
        hold_picture(&format!("tradeoff/{model}"), &tradeoff::svg(&record));
        let text = format!(
            "![{model}: {}](tradeoff/{model}.png)\n\n{}.\n\n{}",
            headline(&record),
            headline(&record),
            runs_table(&record)
        );
        hold("docs/tradeoff.md", &format!("tradeoff {model}"), &text);
    }
    let scaling: scaling::Scaling = serde_json::from_str(&file("docs/scaling.json")).unwrap();
    hold_picture("scaling", &scaling::svg(&scaling));
    let text = format!(
        "![Time by stage, time by rung and memory against the number of faces](scaling.png)\n\n```\n{}\n```",
        scaling::text(&scaling).trim_end()
    );
    hold("docs/tradeoff.md", "scaling", &text);
}

#[test]
fn curves_are_what_the_records_say() {
    let records = CURVES.map(record);
    hold_picture("curves", &tradeoff::curves_svg(&records.each_ref()));
    let curves = records.each_ref().map(|record| {
        (record.model.as_str(), record.curve.as_ref().expect("no curve: run docs/tradeoff.sh"))
    });
    let headlines = curves.map(|(model, curve)| format!("- {model}: {}.\n", curve_headline(curve).unwrap()));
    let shares =
        curves[0].1.best().unwrap().points.iter().map(|point| format!("{} of the area", point.share));
    let heading: Vec<String> = std::iter::once("fitted budgets, dB".to_owned()).chain(shares).collect();
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    let rows = curves.map(|(model, curve)| {
        let cells = curve.best().unwrap().points.iter().map(|point| gain(&point.end));
        std::iter::once(model.to_owned()).chain(cells).collect()
    });
    let text = format!(
        "![Texels against error, five models](curves.png)\n\n{}\n{}",
        headlines.concat(),
        markdown(&heading, rows.into_iter())
    );
    hold("docs/storage.md", "curves", &text);
    hold_picture("tradeoff/DamagedHelmet-curve", &tradeoff::curve_svg(&records[0]).unwrap());
}

/// Of base color over plain resampling; with several maps also the mean and the worst of all.
fn gain(end: &PointEnd) -> String {
    let PointEnd::Done(figures) = end else { return "refused".to_owned() };
    let ([ours, plain], [mean, worst, _]) = (figures.color_psnr_db().unwrap(), figures.gains_db().unwrap());
    let color = format!("{:+.1}", ours - plain);
    if figures.maps.len() == 1 { color } else { format!("{color} ({mean:+.1}, {worst:+.1})") }
}

#[test]
fn the_readme_shows_what_the_records_say() {
    let records = MODELS.map(record);
    let preset = |record: &Tradeoff, name: &str| {
        let done = record.presets.iter().find(|preset| preset.name == name).map(|preset| preset.run);
        let Some(End::Done(done)) = done.map(|run| record.runs[run].end.clone()) else {
            return "refused".to_owned();
        };
        let errors = done.errors.main().map_or_else(String::new, |(errors, unit)| {
            let levels = errors.all_levels_rms.map_or_else(String::new, |rms| format!(", {}", figure(rms)));
            let seams = if done.is_seamless { "" } else { ", seams" };
            format!("{}{levels} {unit}{seams}", figure(errors.level_0.rms))
        });
        format!("{}, {errors}", time(done.cost.converting_cpu_seconds))
    };
    let names: Vec<&str> = records[0].presets.iter().map(|preset| preset.name.as_str()).collect();
    let rows = records.iter().map(|record| {
        let cells = names.iter().map(|name| preset(record, name));
        std::iter::once(format!("[{0}](docs/tradeoff/{0}.png)", record.model)).chain(cells).collect()
    });
    let heading: Vec<&str> = std::iter::once("model").chain(names.iter().copied()).collect();
    let helmet = &records[2];
    let text = format!(
        "![{}: {}](docs/tradeoff/{}.png)\n\n{}",
        helmet.model,
        headline(helmet),
        helmet.model,
        markdown(&heading, rows)
    );
    hold("README.md", "tradeoff", &text);
}

/// Of every record, that of the scaling bench too.
#[test]
fn records_are_of_todays_runs() {
    let plan = Plan::new(&Options::default()).unwrap();
    for model in MODELS {
        let runs: Vec<_> = record(model).runs.into_iter().map(|run| (run.name, run.options)).collect();
        let planned: Vec<_> = plan.runs.iter().map(|run| (run.name.clone(), run.options.to_json())).collect();
        assert!(runs == planned, "{model}: rungs have changed: run docs/tradeoff.sh");
    }
    let scaling: scaling::Scaling = serde_json::from_str(&file("docs/scaling.json")).unwrap();
    let mut names: Vec<_> = scaling.sizes[0].runs.iter().map(|run| run.name.clone()).collect();
    let mut planned: Vec<_> = plan.runs.iter().map(|run| run.name.clone()).collect();
    names.sort();
    planned.sort();
    assert_eq!(names, planned, "rungs have changed: run docs/tradeoff.sh scaling");
}

#[test]
fn the_samples_errors_are_what_conversions_give_today() {
    let record = record("sample");
    let plan = Plan::new(&Options::default()).unwrap();
    let upload = Upload::single("sample.glb", meshcolor_service::sample::model());
    for (run, planned) in record.runs.iter().zip(&plan.runs) {
        let End::Done(done) = &run.end else { panic!("the sample refuses {}", run.name) };
        let now = convert(&upload, &planned.options, &Limits::default(), &Unwatched).unwrap();
        let errors = tradeoff::errors_of(&now.report);
        for (there, now) in figures(&done.errors).into_iter().zip(figures(&errors)) {
            assert_eq!(there.0, now.0, "{}: run docs/tradeoff.sh", run.name);
            let is_near = (there.1 - now.1).abs() <= TOLERANCE * (1.0 + there.1.abs());
            assert!(is_near, "{}: {there:?} has become {}; run docs/tradeoff.sh", run.name, now.1);
        }
        assert!(done.is_seamless || run.name != HOME);
    }
}

/// Every error by a name, whatever is there.
fn figures(errors: &Errors) -> Vec<(String, f64)> {
    let mut all = Vec::new();
    let units: [(&str, &Option<UnitErrors>); 2] = [("codes", &errors.codes), ("degrees", &errors.degrees)];
    for (unit, found) in units.iter().filter_map(|(unit, errors)| Some((unit, errors.as_ref()?))) {
        let mut add = |name: &str, value: Option<f64>| {
            all.extend(value.map(|value| (format!("{unit} {name}"), value)));
        };
        add("level 0", Some(found.level_0.rms));
        add("level 0 99 %", found.level_0.p99);
        add("level 0 max", found.level_0.max);
        add("all levels", found.all_levels_rms);
        add("seam", Some(found.seam_max));
        add("seam 99.9 %", Some(found.seam_p999));
        for level in &found.levels {
            add(&format!("level {}", level.level), Some(level.error.rms));
        }
    }
    if let Some(change) = &errors.change {
        all.push(("change".to_owned(), change.mean_codes));
        all.push(("largest change".to_owned(), change.max_codes));
        all.extend(change.p95_codes.map(|p95| ("change 95 %".to_owned(), p95)));
    }
    all
}

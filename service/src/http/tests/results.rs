use std::io::Cursor;
use std::sync::atomic::Ordering;

use super::bench::Bench;
use crate::settings::Settings;

#[tokio::test]
async fn bundles_are_served_whole_in_part_and_not_again() {
    let bench = Bench::new().await;
    let parts = [(r#"name="model"; filename="Stühle.glb""#, "ok")];
    let id = bench.post_parts("/v1/jobs", &parts).await.id();
    let job = bench.until(&id, "succeeded").await;
    let path = format!("/v1/jobs/{id}/bundle");
    let whole = bench.get(&path).await;
    assert_eq!(whole.status, 200);
    let tag = whole.header("etag").to_owned();
    assert_eq!(tag, format!("\"{}\"", job["bundle"]["sha256"].as_str().unwrap()));
    assert_eq!(job["bundle"]["bytes"], whole.body.len());
    assert_eq!(whole.header("content-type"), "application/zip");
    assert_eq!(whole.header("accept-ranges"), "bytes");
    assert_eq!(whole.header("cache-control"), "private, max-age=31536000, immutable");
    let disposition =
        r#"attachment; filename="St_hle-meshcolor.zip"; filename*=UTF-8''St%C3%BChle-meshcolor.zip"#;
    assert_eq!(whole.header("content-disposition"), disposition);
    let length = whole.body.len();
    assert_eq!(whole.header("content-length"), length.to_string());
    zip::ZipArchive::new(Cursor::new(whole.body.clone())).unwrap();

    let range = async |value: &str| bench.call("GET", &path, &[("range", value)], "").await;
    let part = range("bytes=2-5").await;
    assert_eq!((part.status.as_u16(), &part.body[..]), (206, &whole.body[2..6]));
    assert_eq!(part.header("content-range"), format!("bytes 2-5/{length}"));
    assert_eq!(range("bytes=-4").await.body, whole.body[length - 4..]);
    let outside = range("bytes=999999-").await;
    outside.problem(416, "range_not_satisfiable");
    assert_eq!(outside.header("content-range"), format!("bytes */{length}"));

    let stale = [("range", "bytes=2-5"), ("if-range", "\"old\"")];
    assert_eq!(bench.call("GET", &path, &stale, "").await.body, whole.body);
    let fresh = [("range", "bytes=2-5"), ("if-range", tag.as_str())];
    assert_eq!(bench.call("GET", &path, &fresh, "").await.status, 206);
    let known = bench.call("GET", &path, &[("if-none-match", &tag)], "").await;
    assert_eq!((known.status.as_u16(), known.body.len()), (304, 0));
    let head = bench.call("HEAD", &path, &[], "").await;
    assert_eq!((head.header("content-length"), head.body.len()), (length.to_string().as_str(), 0));
}

#[tokio::test]
async fn results_come_when_the_job_has_succeeded() {
    let bench = Bench::new().await;
    let failed = bench.finish("invalid").await;
    let running = bench.submit("wait").await.id();
    bench.until(&running, "running").await;
    for file in ["bundle", "report", "preview.png"] {
        let early = bench.get(&format!("/v1/jobs/{running}/{file}")).await;
        early.problem(409, "not_finished");
        assert_eq!(early.header("retry-after"), "1");
        let never = bench.get(&format!("/v1/jobs/{failed}/{file}")).await;
        let problem = never.problem(409, "not_succeeded");
        assert!(problem["detail"].as_str().unwrap().contains("index 9 of 3"));
    }
    bench.runner.gate.store(true, Ordering::SeqCst);
}

#[tokio::test]
async fn reports_come_as_json_alone() {
    let bench = Bench::new().await;
    let id = bench.finish("ok").await;
    let path = format!("/v1/jobs/{id}/report");
    let report = bench.get(&path).await;
    assert_eq!(report.json()["verdict"], "warn");
    assert_eq!(report.header("content-type"), "application/json");
    let known = [("if-none-match", report.header("etag"))];
    assert_eq!(bench.call("GET", &path, &known, "").await.status, 304);
    for accept in ["application/json", "text/html, application/*;q=0.5", "*/*"] {
        assert_eq!(bench.call("GET", &path, &[("accept", accept)], "").await.status, 200, "{accept}");
    }
    bench
        .call("GET", &path, &[("accept", "application/sarif+json")], "")
        .await
        .problem(406, "not_acceptable");
    bench.get(&format!("{path}?format=sarif")).await.problem(406, "not_acceptable");
    assert_eq!(bench.get(&format!("{path}?format=json")).await.status, 200);
}

#[tokio::test]
async fn pictures_come_in_a_few_sizes() {
    let bench = Bench::new().await;
    let id = bench.finish("ok").await;
    let path = format!("/v1/jobs/{id}/preview.png");
    let size = |answer: &super::bench::Answer| {
        assert_eq!(answer.header("content-type"), "image/png");
        let picture = image::load_from_memory(&answer.body).unwrap();
        (picture.width(), picture.height())
    };
    assert_eq!(size(&bench.get(&path).await), (300, 150));
    assert_eq!(size(&bench.get(&format!("{path}?size=128")).await), (128, 64));
    assert_eq!(size(&bench.get(&format!("{path}?size=1024")).await), (300, 150));
    for wrong in ["size=65", "size=0", "size=x", "size=99999999999", "width=64"] {
        bench.get(&format!("{path}?{wrong}")).await.problem(400, "invalid_parameter");
    }
    let answer = bench.call("POST", "/v1/jobs?preview=false", &[("content-type", "model/obj")], "ok").await;
    bench.until(&answer.id(), "succeeded").await;
    bench.get(&format!("/v1/jobs/{}/preview.png", answer.id())).await.problem(404, "not_found");
}

#[tokio::test]
async fn one_request_converts_and_one_checks() {
    let bench = Bench::new().await;
    let model = [(r#"name="model"; filename="a.glb""#, "ok")];
    let bundle = bench.post_parts("/v1/convert", &model).await;
    assert_eq!((bundle.status.as_u16(), bundle.header("content-type")), (200, "application/zip"));
    assert!(bundle.header("location").starts_with("/v1/jobs/job_"));
    let report = bench.post_parts("/v1/check", &model).await;
    assert_eq!(report.json()["verdict"], "warn");
    let job = bench.get(report.header("location")).await.json();
    assert_eq!((&job["kind"], &job["bundle"]), (&"check".into(), &serde_json::Value::Null));
    bench.get(&format!("{}/bundle", report.header("location"))).await.problem(404, "not_found");
}

#[tokio::test]
async fn one_request_that_takes_long_goes_on_as_a_job() {
    let settings = Settings { sync_timeout_seconds: 0, ..Settings::default() };
    let bench = Bench::with(settings).await;
    let model = [(r#"name="model"; filename="a.glb""#, "wait")];
    for path in ["/v1/convert", "/v1/check"] {
        let answer = bench.post_parts(path, &model).await;
        assert_eq!(answer.status, 202);
        assert_eq!(answer.header("location"), format!("/v1/jobs/{}", answer.id()));
        assert_eq!(answer.header("retry-after"), "1");
    }
    bench.runner.gate.store(true, Ordering::SeqCst);
}

#[tokio::test]
async fn one_request_that_fails_says_whose_fault_it_is() {
    let bench = Bench::new().await;
    let convert = async |model: &str| {
        bench.call("POST", "/v1/convert", &[("content-type", "application/zip")], model.to_owned()).await
    };
    let problem = convert("invalid").await.problem(422, "invalid_model");
    assert_eq!((&problem["pointer"], &problem["instance"]), (&"/accessors/0".into(), &"/v1/convert".into()));
    let problem = convert("image").await.problem(422, "image_too_large");
    assert_eq!(
        (problem["limit"].as_u64(), problem["actual"].as_u64()),
        (Some(67_108_864), Some(900_000_000))
    );
    assert!(problem["detail"].as_str().unwrap().contains("MESHCOLOR_MAX_IMAGE_PIXELS"));
    convert("panic").await.problem(500, "internal");
    convert("broken").await.problem(500, "internal");
}

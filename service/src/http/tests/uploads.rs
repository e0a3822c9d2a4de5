use std::time::Duration;

use axum::body::Body;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use futures_util::{StreamExt, stream};
use sha2::{Digest, Sha256};

use super::bench::{Bench, MULTIPART, multipart};
use crate::settings::Settings;

const MODEL: (&str, &str) = (r#"name="model"; filename="a.glb""#, "ok");

/// A body that comes in pieces, without a length.
fn pieces(pieces: Vec<Bytes>) -> Body {
    Body::from_stream(stream::iter(pieces.into_iter().map(Ok::<_, std::io::Error>)))
}

#[tokio::test]
async fn malformed_uploads_are_refused_with_their_reason_and_leave_nothing() {
    let bench = Bench::new().await;
    let header = "x".repeat(1 << 20);
    let options = format!(r#"{{"cut":"{}"}}"#, "1".repeat(70_000));
    let whole = multipart(&[MODEL]);
    let cases: Vec<(&str, String, u16, &str)> = vec![
        ("multipart/form-data", whole.clone(), 400, "malformed_multipart"),
        ("multipart/form-data; boundary=YY", whole.clone(), 400, "malformed_multipart"),
        (MULTIPART, String::new(), 400, "malformed_multipart"),
        (MULTIPART, "--XX--\r\n".into(), 400, "missing_part"),
        (MULTIPART, whole[..whole.len() - 12].into(), 400, "malformed_multipart"),
        (MULTIPART, whole[..20].into(), 400, "malformed_multipart"),
        (MULTIPART, multipart(&[MODEL, MODEL]), 400, "malformed_multipart"),
        (MULTIPART, multipart(&[(r#"name="options""#, "{}")]), 400, "missing_part"),
        (
            MULTIPART,
            multipart(&[MODEL, (r#"name="texture"; filename="a""#, "x")]),
            400,
            "malformed_multipart",
        ),
        (MULTIPART, multipart(&[MODEL, (r#"name="files""#, "x")]), 400, "malformed_multipart"),
        (
            MULTIPART,
            multipart(&[MODEL, (r#"name="files"; filename="a.glb""#, "x")]),
            400,
            "malformed_multipart",
        ),
        (MULTIPART, multipart(&[MODEL, (r#"name="options""#, "[]")]), 400, "invalid_options"),
        (MULTIPART, multipart(&[MODEL, (r#"name="options""#, "{")]), 400, "invalid_options"),
        (
            MULTIPART,
            multipart(&[MODEL, (r#"name="options""#, r#"{"solver":"magic"}"#)]),
            400,
            "invalid_options",
        ),
        (MULTIPART, multipart(&[MODEL, (r#"name="options""#, r#"{"webhook":"x"}"#)]), 400, "invalid_options"),
        (
            MULTIPART,
            multipart(&[MODEL, (r#"name="options""#, "{}"), (r#"name="options""#, "{}")]),
            400,
            "malformed_multipart",
        ),
        (MULTIPART, multipart(&[(r#"name="options""#, &options), MODEL]), 413, "body_too_large"),
        (
            MULTIPART,
            multipart(&[(&format!(r#"name="files"; filename="{header}""#), "x"), MODEL]),
            400,
            "malformed_multipart",
        ),
        (MULTIPART, multipart(&[(r#"name="files"; filename="a""#, ""); 2]), 400, "malformed_multipart"),
        ("text/html", "ok".into(), 415, "unsupported_media_type"),
        ("", "ok".into(), 415, "unsupported_media_type"),
        ("model/gltf-binary", String::new(), 400, "missing_part"),
    ];
    for (index, (kind, body, status, code)) in cases.into_iter().enumerate() {
        let answer = bench.call("POST", "/v1/jobs", &[("content-type", kind)], body).await;
        assert_eq!(answer.status.as_u16(), status, "case {index}: {}", answer.text());
        answer.problem(status, code);
    }
    let answer = bench.call("POST", "/v1/jobs?solver=magic", &[("content-type", "model/obj")], "ok").await;
    let problem = answer.problem(400, "invalid_options");
    assert_eq!(problem["pointer"], "/solver");
    assert!(problem["detail"].as_str().unwrap().contains("clamp, local, global"));
    assert_eq!(bench.scratch.job_files(), Vec::<String>::new());
    assert!(bench.get("/v1/jobs").await.json()["jobs"].as_array().unwrap().is_empty());
}

#[tokio::test]
async fn ten_thousand_empty_parts_are_too_many() {
    let bench = Bench::new().await;
    let names: Vec<_> = (0..10_000).map(|index| format!(r#"name="files"; filename="{index}""#)).collect();
    let parts: Vec<_> = names.iter().map(|name| (name.as_str(), "")).collect();
    let problem = bench.post_parts("/v1/jobs", &parts).await.problem(413, "too_many_files");
    assert_eq!(problem["limit"], 256);
    assert_eq!(bench.scratch.job_files(), Vec::<String>::new());
}

#[tokio::test]
async fn bodies_end_at_their_limit_whatever_their_headers_say() {
    let settings = Settings { max_body_bytes: 100_000, ..Settings::default() };
    let bench = Bench::with(settings).await;
    let raw = [("content-type", "model/gltf-binary")];
    let exact = bench.call("POST", "/v1/jobs", &raw, vec![b'x'; 100_000]).await;
    assert_eq!(exact.status, 202, "{}", exact.text());
    let over = bench
        .call("POST", "/v1/jobs", &raw, pieces(vec![vec![0; 50_000].into(), vec![0; 50_001].into()]))
        .await;
    let problem = over.problem(413, "body_too_large");
    assert_eq!(problem["limit"], 100_000);
    assert_eq!(over.header("connection"), "close");
    let declared = [raw[0], ("content-length", "100001")];
    let problem = bench.call("POST", "/v1/jobs", &declared, "ok").await.problem(413, "body_too_large");
    assert_eq!(problem["actual"], 100_001);
    let big = "x".repeat(120_000);
    bench
        .post_parts("/v1/jobs", &[(r#"name="model"; filename="a""#, &big)])
        .await
        .problem(413, "body_too_large");
}

#[tokio::test]
async fn an_endless_body_is_not_read_to_its_end() {
    let settings = Settings { max_body_bytes: 1 << 20, ..Settings::default() };
    let bench = Bench::with(settings).await;
    for kind in ["model/gltf-binary", MULTIPART] {
        let read = std::sync::Arc::new(std::sync::atomic::AtomicU64::new(0));
        let counted = read.clone();
        let start =
            stream::iter([Bytes::from("--XX\r\nContent-Disposition: form-data; name=\"model\"\r\n\r\n")]);
        let rest = stream::repeat_with(move || {
            counted.fetch_add(1 << 14, std::sync::atomic::Ordering::Relaxed);
            Bytes::from(vec![0; 1 << 14])
        });
        let body = Body::from_stream(start.chain(rest).map(Ok::<_, std::io::Error>));
        bench.call("POST", "/v1/jobs", &[("content-type", kind)], body).await.problem(413, "body_too_large");
        let read = read.load(std::sync::atomic::Ordering::Relaxed);
        assert!(read <= (1 << 20) + (64 << 10), "{read} bytes were read");
    }
    assert_eq!(bench.scratch.job_files(), Vec::<String>::new());
}

#[tokio::test]
async fn an_endless_part_header_is_not_collected() {
    let bench = Bench::new().await;
    let endless = stream::repeat_with(|| Ok::<_, std::io::Error>(Bytes::from(vec![b'a'; 1 << 14])));
    let start = stream::iter([Ok(Bytes::from("--XX\r\nContent-Disposition: form-data; name=\""))]);
    let body = Body::from_stream(start.chain(endless));
    let answer = bench.call("POST", "/v1/jobs", &[("content-type", MULTIPART)], body).await;
    assert_eq!(answer.problem(400, "malformed_multipart")["limit"], 8192);
}

#[tokio::test]
async fn silence_and_slowness_end_an_upload() {
    let settings =
        Settings { body_idle_timeout_seconds: 1, upload_timeout_seconds: 2, ..Settings::default() };
    let bench = Bench::with(settings).await;
    let start = stream::iter([Ok::<_, std::io::Error>(Bytes::from("glTF"))]);
    let body = Body::from_stream(start.chain(stream::pending()));
    let answer = bench.call("POST", "/v1/jobs", &[("content-type", "model/gltf-binary")], body).await;
    assert_eq!(answer.problem(408, "upload_too_slow")["limit"], 1);
    let drip = stream::unfold((), async |()| {
        tokio::time::sleep(Duration::from_millis(100)).await;
        Some((Ok::<_, std::io::Error>(Bytes::from("x")), ()))
    });
    let drip = Body::from_stream(drip);
    let answer = bench.call("POST", "/v1/jobs", &[("content-type", "model/gltf-binary")], drip).await;
    assert_eq!(answer.problem(408, "upload_too_slow")["limit"], 2);
    assert_eq!(bench.scratch.job_files(), Vec::<String>::new());
}

#[tokio::test]
async fn a_client_that_breaks_off_leaves_nothing() {
    let bench = Bench::new().await;
    for kind in ["model/gltf-binary", MULTIPART] {
        let broken = stream::iter([Ok(Bytes::from("--XX\r\n")), Err(std::io::Error::other("reset"))]);
        let answer =
            bench.call("POST", "/v1/jobs", &[("content-type", kind)], Body::from_stream(broken)).await;
        answer.problem(400, "incomplete_body");
    }
    // A handler that is dropped in the middle, as it is when the connection goes away.
    let stuck = Body::from_stream(
        stream::iter([Ok::<_, std::io::Error>(Bytes::from("glTF"))]).chain(stream::pending()),
    );
    let call = bench.call("POST", "/v1/jobs", &[("content-type", "model/gltf-binary")], stuck);
    assert!(tokio::time::timeout(Duration::from_millis(50), call).await.is_err());
    assert_eq!(bench.scratch.job_files(), Vec::<String>::new());
}

#[tokio::test]
async fn digests_are_checked() {
    let bench = Bench::new().await;
    let digest = |text: &str| format!("md5=:AA==:, sha-256=:{}:", STANDARD.encode(Sha256::digest(text)));
    let post = async |kind: &str, body: String, digest: &str| {
        let headers = [("content-type", kind), ("content-digest", digest)];
        bench.call("POST", "/v1/jobs", &headers, body).await
    };
    assert_eq!(post("model/obj", "ok".into(), &digest("ok")).await.status, 202);
    let form = multipart(&[MODEL]) + "an epilogue";
    assert_eq!(post(MULTIPART, form.clone(), &digest(&form)).await.status, 202);
    post("model/obj", "ok".into(), &digest("other")).await.problem(400, "digest_mismatch");
    post("model/obj", "ok".into(), "sha-256=:AA==:").await.problem(400, "digest_mismatch");
    assert_eq!(post("model/obj", "ok".into(), "sha-512=:AA==:").await.status, 202, "not ours to judge");
}

#[tokio::test]
async fn uploads_at_a_time_are_bounded() {
    let settings = Settings { max_concurrent_uploads: 1, ..Settings::default() };
    let bench = Bench::with(settings).await;
    let slow = Body::from_stream(stream::pending::<Result<Bytes, std::io::Error>>());
    let first = bench.call("POST", "/v1/jobs", &[("content-type", "model/obj")], slow);
    let second = async {
        while bench.app.uploads.available_permits() > 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        bench.submit("ok").await
    };
    tokio::select! {
        _ = first => panic!("the first one has no end"),
        answer = second => answer.problem(429, "too_many_uploads"),
    };
    assert_eq!(bench.submit("ok").await.status, 202);
}

#[tokio::test]
async fn evil_names_are_data() {
    let bench = Bench::new().await;
    let long = "n".repeat(300);
    let names = [
        "../../x.glb",
        "C:\\x.glb",
        "\\\\host\\x.glb",
        "/etc/passwd",
        "\u{202e}blg.a",
        "e\u{301}.glb",
        "é.glb",
        &long,
        "a;b=c.glb",
        "<script>.glb",
    ];
    for name in names {
        let model = format!(r#"name="model"; filename="{name}""#);
        let sidecar = format!(r#"name="files"; filename="sub/{name}""#);
        let answer = bench.post_parts("/v1/jobs", &[(&model, "ok"), (&sidecar, "x")]).await;
        assert_eq!(answer.status, 202, "{name}: {}", answer.text());
        let job = bench.until(&answer.id(), "succeeded").await;
        let shown = job["input"]["name"].as_str().unwrap();
        assert!(shown.chars().count() <= 256 && !shown.contains(".."), "{shown}");
        let bundle = bench.get(&format!("/v1/jobs/{}/bundle", answer.id())).await;
        let disposition = bundle.header("content-disposition");
        assert!(disposition.is_ascii() && !disposition.contains(['<', '\\']), "{disposition}");
    }
    // An input goes soon after its job has succeeded.
    let has_input = |files: &[String]| files.iter().any(|file| file.split('/').any(|part| part == "input"));
    let mut files = bench.scratch.job_files();
    while has_input(&files) {
        tokio::time::sleep(std::time::Duration::from_millis(2)).await;
        files = bench.scratch.job_files();
    }
    // Only names of our own are on disk.
    for file in files {
        let is_ours = |part: &str| {
            part.starts_with("job_")
                || matches!(part, "result" | "bundle.zip" | "report.json" | "preview.png")
        };
        assert!(file.split('/').all(is_ours), "{file}");
    }
}

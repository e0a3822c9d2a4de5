use std::sync::atomic::Ordering;

use super::bench::Bench;
use crate::settings::Settings;

#[tokio::test]
async fn a_submission_is_accepted_followed_and_done() {
    let bench = Bench::new().await;
    let parts = [
        (r#"name="options""#, r#"{"resolution":"fixed:3","preview":false}"#),
        (r#"name="files"; filename="tex/a.png""#, "png"),
        (r#"name="model"; filename="chair.glb""#, "ok"),
    ];
    let answer = bench.post_parts("/v1/jobs", &parts).await;
    assert_eq!(answer.status, 202, "{}", answer.text());
    assert_eq!(answer.header("location"), format!("/v1/jobs/{}", answer.id()));
    assert_eq!(answer.header("retry-after"), "1");
    let job = bench.call("GET", answer.header("location"), &[("prefer", "wait=20")], "").await;
    assert_eq!(job.header("preference-applied"), "wait=20");
    let job = job.json();
    assert_eq!((&job["state"], &job["verdict"]), (&"succeeded".into(), &"warn".into()));
    assert_eq!(job["options"]["resolution"], "fixed:3");
    assert_eq!(job["options"]["solver"], "global");
    assert_eq!(job["options"]["preview"], false);
    assert_eq!(job["input"]["name"], "chair.glb");
    assert_eq!(job["input"]["bytes"], 5);
    assert_eq!(job["attempt"], 1);
    assert_eq!(job["progress"]["percent"], 100);
    assert_eq!(job["progress"]["stages"].as_array().unwrap().len(), 10);
    assert_eq!(job["preview"], serde_json::Value::Null);
    assert_eq!(job["report"]["max_seam_delta"], 0.75);
    for field in ["created_at", "started_at", "finished_at"] {
        assert!(job[field].as_str().unwrap().ends_with('Z'), "{field}");
    }
}

#[tokio::test]
async fn a_preferred_wait_answers_with_the_end() {
    let bench = Bench::new().await;
    let headers = [("content-type", "model/obj"), ("prefer", "wait=20")];
    let answer = bench.call("POST", "/v1/jobs?cut=3", &headers, "ok").await;
    assert_eq!(answer.status, 200);
    assert_eq!(answer.json()["options"]["cut"], 3.0);
    assert!(answer.header("location").starts_with("/v1/jobs/job_"));
}

#[tokio::test]
async fn tags_tell_whether_a_job_has_changed() {
    let bench = Bench::new().await;
    let id = bench.submit("wait").await.id();
    let path = format!("/v1/jobs/{id}");
    bench.until(&id, "running").await;
    loop {
        let tag = bench.get(&path).await.header("etag").to_owned();
        let again = bench.call("GET", &path, &[("if-none-match", &tag)], "").await;
        if again.status == 304 {
            assert!(again.body.is_empty());
            let headers = [("if-none-match", tag.as_str()), ("prefer", "wait=20")];
            let waiting = bench.call("GET", &path, &headers, "");
            let open = async { bench.runner.gate.store(true, Ordering::SeqCst) };
            let (changed, ()) = tokio::join!(waiting, open);
            assert_eq!(changed.status, 200);
            return;
        }
    }
}

#[tokio::test]
async fn queued_jobs_know_their_place() {
    let bench = Bench::new().await;
    let first = bench.submit("wait").await.id();
    bench.until(&first, "running").await;
    let (second, third) = (bench.submit("ok").await, bench.submit("ok").await);
    assert_eq!((&second.json()["queue_position"], &third.json()["queue_position"]), (&1.into(), &2.into()));
    bench.call("DELETE", &format!("/v1/jobs/{}", second.id()), &[], "").await;
    let third = bench.get(&format!("/v1/jobs/{}", third.id())).await;
    assert_eq!(third.json()["queue_position"], 1);
    bench.runner.gate.store(true, Ordering::SeqCst);
}

#[tokio::test]
async fn lists_come_in_pages_newest_first() {
    let bench = Bench::new().await;
    let mut ids = Vec::new();
    for _ in 0..5 {
        ids.insert(0, bench.finish("ok").await);
    }
    let failed = bench.finish("invalid").await;
    ids.insert(0, failed.clone());
    let (mut seen, mut path) = (Vec::new(), "/v1/jobs?page_size=4".to_owned());
    loop {
        let page = bench.get(&path).await.json();
        seen.extend(
            page["jobs"].as_array().unwrap().iter().map(|job| job["id"].as_str().unwrap().to_owned()),
        );
        let Some(token) = page["next_page_token"].as_str() else { break };
        path = format!("/v1/jobs?page_size=4&page_token={token}");
    }
    assert_eq!(seen, ids);
    let page = bench.get("/v1/jobs?state=failed").await.json();
    assert_eq!(page["jobs"].as_array().unwrap().len(), 1);
    assert_eq!(page["jobs"][0]["id"], failed);
    assert_eq!(page["jobs"][0]["error"]["pointer"], "/accessors/0");
    let wrong = [
        "state=done",
        "page_size=0",
        "page_size=201",
        "page_size=x",
        "page_token=x",
        "colour=red",
        "state=failed&state=failed",
        "%ff=%ff",
    ];
    for query in wrong {
        let answer = bench.get(&format!("/v1/jobs?{query}")).await;
        answer.problem(400, "invalid_parameter");
    }
}

#[tokio::test]
async fn cancel_is_final_and_may_be_repeated() {
    let bench = Bench::new().await;
    let running = bench.submit("wait").await.id();
    bench.until(&running, "running").await;
    let queued = bench.submit("ok").await.id();
    let cancel = async |id: &str| bench.call("POST", &format!("/v1/jobs/{id}/cancel"), &[], "").await;
    let answer = cancel(&queued).await;
    assert_eq!((answer.status.as_u16(), &answer.json()["state"]), (200, &"canceled".into()));
    let answer = cancel(&running).await;
    assert!(answer.status == 202 || answer.json()["state"] == "canceled", "{}", answer.text());
    bench.until(&running, "canceled").await;
    for id in [&running, &queued] {
        assert_eq!(cancel(id).await.json()["state"], "canceled");
    }
    let done = bench.finish("ok").await;
    let before = bench.get(&format!("/v1/jobs/{done}")).await.body;
    let answer = cancel(&done).await;
    assert_eq!((answer.status.as_u16(), answer.body), (200, before));
    cancel("job_00000000000000000000000000000000").await.problem(404, "not_found");
}

#[tokio::test]
async fn deleted_jobs_are_gone_with_their_files() {
    let bench = Bench::new().await;
    let done = bench.finish("ok").await;
    let path = format!("/v1/jobs/{done}");
    assert_eq!(bench.call("DELETE", &path, &[], "").await.status, 204);
    bench.call("DELETE", &path, &[], "").await.problem(404, "not_found");
    for file in ["", "/bundle", "/report", "/preview.png", "/events"] {
        bench.get(&format!("{path}{file}")).await.problem(404, "not_found");
    }
    assert_eq!(bench.scratch.job_files(), Vec::<String>::new());
}

#[tokio::test]
async fn what_is_no_job_is_not_found() {
    let bench = Bench::new().await;
    for id in ["x", "job_", "job_x", "%ff%fe", "..%2f..%2fetc", "job_00000000000000000000000000000000"] {
        bench.get(&format!("/v1/jobs/{id}")).await.problem(404, "not_found");
    }
}

#[tokio::test]
async fn a_full_queue_refuses_and_says_when_to_come_back() {
    let settings = Settings { queue_max: 2, ..Settings::default() };
    let bench = Bench::with(settings).await;
    let first = bench.submit("wait").await.id();
    bench.until(&first, "running").await;
    for _ in 0..2 {
        assert_eq!(bench.submit("ok").await.status, 202);
    }
    let refused = bench.submit("ok").await;
    let problem = refused.problem(429, "queue_full");
    assert_eq!((problem["limit"].as_u64(), refused.header("retry-after")), (Some(2), "5"));
    assert!(problem["detail"].as_str().unwrap().contains("MESHCOLOR_QUEUE_MAX"));
    bench.runner.gate.store(true, Ordering::SeqCst);
}

#[tokio::test]
async fn a_stopping_service_takes_nothing_and_lets_waits_go() {
    let bench = Bench::new().await;
    let id = bench.submit("wait").await.id();
    let path = format!("/v1/jobs/{id}");
    let waiting = bench.call("GET", &path, &[("prefer", "wait=60")], "");
    let stop = async { bench.app.queue.begin_close() };
    let (job, ()) = tokio::join!(waiting, stop);
    assert_eq!(job.status, 200);
    bench.submit("ok").await.problem(503, "shutting_down");
    assert_eq!(bench.get("/readyz").await.status, 503);
    assert_eq!(bench.get("/livez").await.status, 200);
    bench.runner.gate.store(true, Ordering::SeqCst);
}

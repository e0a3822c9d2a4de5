use std::sync::atomic::Ordering;

use serde_json::Value;

use super::bench::Bench;

/// Events as (id, name, data).
fn parse(text: &str) -> Vec<(u64, String, Value)> {
    let field = |event: &str, name: &str| {
        event
            .lines()
            .find_map(|line| line.strip_prefix(name)?.strip_prefix(": "))
            .unwrap_or_default()
            .to_owned()
    };
    text.split("\n\n")
        .filter(|event| event.contains("event: "))
        .map(|event| {
            let data = serde_json::from_str(&field(event, "data")).unwrap();
            (field(event, "id").parse().unwrap(), field(event, "event"), data)
        })
        .collect()
}

#[tokio::test]
async fn a_job_is_told_from_its_state_to_its_end() {
    let bench = Bench::new().await;
    let id = bench.submit("wait").await.id();
    let path = format!("/v1/jobs/{id}/events");
    bench.until(&id, "running").await;
    let open = async {
        let mut follower = bench.app.queue.follow(id.parse().unwrap()).unwrap();
        while follower.borrow_and_update().percent == 0 {
            follower.changed().await.unwrap();
        }
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
        bench.runner.gate.store(true, Ordering::SeqCst);
    };
    let (answer, ()) = tokio::join!(bench.get(&path), open);
    assert_eq!(answer.header("content-type"), "text/event-stream");
    let events = parse(&answer.text());
    assert!(events.windows(2).all(|pair| pair[0].0 < pair[1].0), "ids rise: {}", answer.text());
    let names: Vec<_> = events.iter().map(|event| event.1.as_str()).collect();
    assert_eq!((names[0], &names[names.len() - 2..]), ("state", &["state", "done"][..]));
    assert_eq!(events[0].2["state"], "running");
    let progress = events.iter().find(|event| event.1 == "progress" && event.2["percent"] == 23).unwrap();
    assert_eq!(progress.2["stage"], "read");
    assert_eq!(events.last().unwrap().2["state"], "succeeded");
}

#[tokio::test]
async fn a_client_that_comes_back_gets_what_is_new() {
    let bench = Bench::new().await;
    let id = bench.finish("ok").await;
    let path = format!("/v1/jobs/{id}/events");
    let all = parse(&bench.get(&path).await.text());
    assert_eq!(all.iter().map(|event| event.1.as_str()).collect::<Vec<_>>(), ["state", "done"]);
    let since = async |last: u64| {
        let last = last.to_string();
        parse(&bench.call("GET", &path, &[("last-event-id", last.as_str())], "").await.text())
    };
    assert_eq!(since(all[0].0).await, all[1..]);
    assert_eq!(since(all[1].0).await, []);
    assert_eq!(since(0).await, all);
}

#[tokio::test]
async fn events_end_with_the_service_and_with_the_job_record() {
    let bench = Bench::new().await;
    let id = bench.submit("wait").await.id();
    bench.until(&id, "running").await;
    let path = format!("/v1/jobs/{id}/events");
    let delete = async {
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        bench.call("DELETE", &format!("/v1/jobs/{id}"), &[], "").await
    };
    let (answer, _) = tokio::join!(bench.get(&path), delete);
    assert!(parse(&answer.text()).iter().all(|event| event.1 != "done"));
    let id = bench.submit("wait").await.id();
    let path = format!("/v1/jobs/{id}/events");
    let stop = async {
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        bench.app.queue.begin_close();
    };
    let (answer, ()) = tokio::join!(bench.get(&path), stop);
    assert!(parse(&answer.text()).iter().all(|event| event.1 != "done"));
    bench.runner.gate.store(true, Ordering::SeqCst);
}

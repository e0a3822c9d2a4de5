//! `kill -9` at random moments: every accepted job ends once, and nothing is lost.

mod support;

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::Value;
use support::{Folder, Service, model, next};

const ROUNDS: usize = 10;

async fn submit(client: &reqwest::Client, base: &str, model: &[u8]) -> Option<String> {
    let request = client.post(format!("{base}/v1/jobs?preview=false"));
    let request = request.header("content-type", "model/gltf-binary").body(model.to_vec());
    // Whether an answer comes is the kill's doing; only what was answered counts as accepted.
    let response = request.send().await.ok()?;
    assert_eq!(response.status(), 202);
    let job: Value = response.json().await.ok()?;
    Some(job["id"].as_str()?.to_owned())
}

async fn look(client: &reqwest::Client, base: &str, id: &str, wait: &str) -> Value {
    let request = client.get(format!("{base}/v1/jobs/{id}")).header("prefer", wait);
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 200, "{id} is lost");
    response.json().await.unwrap()
}

fn is_ended(job: &Value) -> bool {
    job["finished_at"].is_string()
}

#[tokio::test]
async fn every_accepted_job_ends_once() {
    let data = Folder::new();
    let client = reqwest::Client::builder().no_proxy().build().unwrap();
    let mut random = 20_26;
    let mut ids: Vec<String> = Vec::new();
    let mut ended: BTreeMap<String, Value> = BTreeMap::new();
    for round in 0..ROUNDS {
        let service = Service::start(data.root(), &["--workers", "2"]);
        for id in &ids {
            let job = look(&client, &service.base, id, "wait=0").await;
            if is_ended(&job) {
                let first = ended.entry(id.clone()).or_insert_with(|| job.clone());
                assert_eq!(*first, job, "the end of {id} changed in round {round}");
            } else {
                assert!(!ended.contains_key(id), "{id} had ended and goes on");
            }
        }
        let base = service.base.clone();
        let moment = Duration::from_millis(next(&mut random) % 400);
        let submissions = async {
            let mut accepted = Vec::new();
            for _ in 0..5 {
                let side = 16 << (next(&mut random) % 5);
                let Some(id) = submit(&client, &base, &model(next(&mut random), side)).await else { break };
                accepted.push(id);
            }
            tokio::time::sleep(moment).await;
            accepted
        };
        ids.extend(submissions.await);
        service.kill();
    }
    assert!(ids.len() >= ROUNDS, "too few were accepted: {}", ids.len());

    let service = Service::start(data.root(), &["--workers", "2"]);
    for id in &ids {
        let mut job = look(&client, &service.base, id, "wait=60").await;
        while !is_ended(&job) {
            job = look(&client, &service.base, id, "wait=60").await;
        }
        let first = ended.entry(id.clone()).or_insert_with(|| job.clone());
        assert_eq!(*first, job, "the end of {id} changed");
        assert_eq!(job["attempt"], 1, "interrupted runs count no attempt");
        assert_eq!(job["state"], "succeeded", "{id}: {}", job["error"]);
        check_bundle(&client, &service.base, &job).await;
    }
}

/// The result of a job that succeeded is whole.
async fn check_bundle(client: &reqwest::Client, base: &str, job: &Value) {
    use sha2::{Digest, Sha256};
    let url = format!("{base}{}", job["bundle"]["url"].as_str().unwrap());
    let bytes = client.get(url).send().await.unwrap().bytes().await.unwrap();
    let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(job["bundle"]["sha256"], hash);
}

#[tokio::test]
async fn one_server_at_a_time() {
    let data = Folder::new();
    let first = Service::start(data.root(), &[]);
    let second = support::run(&["serve", "--bind", "127.0.0.1:0", "--data", data.root().to_str().unwrap()]);
    assert_eq!(second.status.code(), Some(4));
    let said = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(said.contains("another meshcolor serves the data folder") && said.contains("--data"), "{said}");
    first.kill();
    Service::start(data.root(), &[]);
}

//! A service without a socket, and requests in few words.

use std::sync::Arc;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderMap, Request, StatusCode};
use serde_json::Value;
use tower::ServiceExt;

use crate::http::{App, router};
use crate::jobs::folder::DataFolder;
use crate::jobs::queue::{Queue, QueueParts};
use crate::jobs::sqlite::SqliteStore;
use crate::jobs::testing::{Scratch, Scripted};
use crate::settings::Settings;

pub struct Bench {
    pub scratch: Scratch,
    pub runner: Arc<Scripted>,
    pub app: Arc<App>,
    router: Router,
}

pub struct Answer {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|_| panic!("not JSON: {}", self.text()))
    }

    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map(|value| value.to_str().unwrap()).unwrap_or_default()
    }

    pub fn id(&self) -> String {
        self.json()["id"].as_str().expect("a job").to_owned()
    }

    /// Asserts that it is a whole problem, and returns it.
    pub fn problem(&self, status: u16, code: &str) -> Value {
        assert_eq!(self.status.as_u16(), status, "{}", self.text());
        assert_eq!(self.header("content-type"), "application/problem+json");
        let problem = self.json();
        assert_eq!(problem["code"], code);
        assert_eq!(problem["status"], status);
        assert_eq!(problem["type"], format!("urn:meshcolor:error:{code}"));
        assert_eq!(problem["request_id"], self.header("x-request-id"));
        for field in ["title", "detail", "instance"] {
            assert!(!problem[field].as_str().unwrap().is_empty(), "{field}");
        }
        assert!(!self.text().contains("secret"));
        problem
    }
}

impl Bench {
    pub async fn new() -> Self {
        Self::with(Settings::default()).await
    }

    pub async fn with(settings: Settings) -> Self {
        let scratch = Scratch::new();
        let runner = Arc::new(Scripted::default());
        let folder = Arc::new(DataFolder::open(scratch.path()).unwrap());
        let store = Arc::new(SqliteStore::open(&folder.database()).await.unwrap());
        let queue = Queue::start(QueueParts {
            store,
            folder,
            runner: runner.clone(),
            limits: settings.limits.clone(),
            queue_max: settings.queue_max,
            worker_count: 1,
        });
        let app = App::new(queue.await.unwrap(), settings);
        Self { scratch, runner, router: router(app.clone()), app }
    }

    pub async fn send(&self, request: Request<Body>) -> Answer {
        let response = self.router.clone().oneshot(request).await.unwrap();
        let (status, headers) = (response.status(), response.headers().clone());
        let body = to_bytes(response.into_body(), usize::MAX).await.unwrap().to_vec();
        assert_eq!(headers["x-content-type-options"], "nosniff");
        assert!(headers.contains_key("content-security-policy"));
        Answer { status, headers, body }
    }

    pub async fn call(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: impl Into<Body>,
    ) -> Answer {
        let request = Request::builder().method(method).uri(path);
        let request = headers.iter().fold(request, |request, (name, value)| request.header(*name, *value));
        self.send(request.body(body.into()).unwrap()).await
    }

    pub async fn get(&self, path: &str) -> Answer {
        self.call("GET", path, &[], "").await
    }

    /// Submits a raw model.
    pub async fn submit(&self, model: &str) -> Answer {
        self.call("POST", "/v1/jobs", &[("content-type", "model/gltf-binary")], model.to_owned()).await
    }

    /// Submits a raw model and waits for its end.
    pub async fn finish(&self, model: &str) -> String {
        let id = self.submit(model).await.id();
        let job = self.call("GET", &format!("/v1/jobs/{id}"), &[("prefer", "wait=20")], "").await;
        assert!(job.json()["finished_at"].is_string(), "{}", job.text());
        id
    }

    /// Waits until a job is in a state.
    pub async fn until(&self, id: &str, state: &str) -> Value {
        loop {
            let job = self.get(&format!("/v1/jobs/{id}")).await.json();
            if job["state"] == state {
                return job;
            }
            tokio::time::sleep(std::time::Duration::from_millis(2)).await;
        }
    }

    /// Posts parts given as (disposition parameters, bytes).
    pub async fn post_parts(&self, path: &str, parts: &[(&str, &str)]) -> Answer {
        let body = multipart(parts);
        self.call("POST", path, &[("content-type", MULTIPART)], body).await
    }
}

pub const MULTIPART: &str = "multipart/form-data; boundary=XX";

pub fn multipart(parts: &[(&str, &str)]) -> String {
    let parts = parts.iter().map(|(parameters, data)| {
        format!("--XX\r\nContent-Disposition: form-data; {parameters}\r\n\r\n{data}\r\n")
    });
    parts.collect::<String>() + "--XX--\r\n"
}

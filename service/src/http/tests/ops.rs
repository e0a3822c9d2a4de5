use super::bench::Bench;

#[tokio::test]
async fn operators_get_their_answers() {
    let bench = Bench::new().await;
    assert_eq!(bench.get("/livez").await.text(), "alive\n");
    let ready = bench.get("/readyz").await.json();
    assert!(["ready", "queue", "storage", "accepting"].iter().all(|check| ready[check] == true), "{ready}");
    let version = bench.get("/version").await.json();
    assert_eq!(version["version"], env!("CARGO_PKG_VERSION"));
    let api = bench.get("/openapi.yaml").await;
    assert_eq!(api.header("content-type"), "application/yaml");
    assert!(api.text().starts_with("openapi: 3.1.0"), "{}", &api.text()[..200]);
}

#[tokio::test]
async fn the_page_explains_itself_and_loads_nothing() {
    let bench = Bench::new().await;
    let page = bench.get("/").await;
    assert_eq!(page.header("content-type"), "text/html; charset=utf-8");
    let text = page.text();
    assert!(text.contains("curl -F model=@chair.glb") && !text.contains("{{"));
    for spec in meshcolor::pipeline::OPTIONS {
        assert!(text.contains(&format!("<code>{}</code>", spec.name)), "{}", spec.name);
    }
    for outside in ["<script", "<img", "<link", "src=", "@import", "url("] {
        assert!(!text.contains(outside), "{outside}");
    }
    let policy = page.header("content-security-policy");
    assert!(policy.starts_with("default-src 'none'; style-src 'sha256-"), "{policy}");
    assert!(!policy.contains("unsafe"), "{policy}");
}

#[tokio::test]
async fn wrong_paths_and_methods_are_problems() {
    let bench = Bench::new().await;
    let problem = bench.get("/v2/jobs").await.problem(404, "not_found");
    assert_eq!(problem["instance"], "/v2/jobs");
    let answer = bench.call("PUT", "/v1/jobs", &[], "").await;
    answer.problem(405, "method_not_allowed");
    let allowed: Vec<_> = answer.header("allow").split(',').collect();
    assert!(allowed.contains(&"POST") && allowed.contains(&"GET"), "{allowed:?}");
}

#[tokio::test]
async fn requests_have_ids_that_are_plain() {
    let bench = Bench::new().await;
    let given = bench.call("GET", "/livez", &[("x-request-id", "abc-123")], "").await;
    assert_eq!(given.header("x-request-id"), "abc-123");
    let long = "x".repeat(129);
    for wrong in ["", "a b", long.as_str()] {
        let made = bench.call("GET", "/livez", &[("x-request-id", wrong)], "").await;
        assert_ne!(made.header("x-request-id"), wrong);
        assert_eq!(made.header("x-request-id").len(), 36);
    }
}

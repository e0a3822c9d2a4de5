//! The demonstration: starts the service on a free port, sends a model over HTTP as any client would,
//! follows it, and keeps what comes back.

use std::fs;
use std::io::{Cursor, Read};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use futures_util::StreamExt;
use meshcolor::measure::Report;
use meshcolor::write::BundleFile;
use reqwest::Client;
use reqwest::multipart::{Form, Part};
use serde_json::Value;

use crate::bundle;
use crate::cli::{bar, before_and_after};
use crate::server::{Config, Server};
use crate::settings::Settings;

/// Longest event that is taken from the service.
const LONGEST_EVENT_BYTES: usize = 1 << 20;

pub struct SentFile {
    pub path: String,
    pub bytes: Vec<u8>,
}

pub struct Plan {
    /// The model first.
    pub files: Vec<SentFile>,
    pub out: PathBuf,
    pub threads: usize,
}

/// Runs the demonstration.
///
/// # Errors
/// Whatever the service answered, in its own words.
pub async fn run(plan: Plan) -> anyhow::Result<()> {
    let data = tempfile::Builder::new().prefix("meshcolor-demo-").tempdir()?;
    let server = Server::start(Config {
        bind: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
        data: data.path().to_owned(),
        worker_count: 1,
        threads: plan.threads,
        settings: Settings::default(),
    })
    .await?;
    let service =
        Service { client: Client::builder().no_proxy().build()?, base: format!("http://{}", server.address) };
    eprintln!("serving on {}", service.base);
    let done = converse(&service, plan).await;
    server.stop().await;
    drop(data);
    done
}

async fn converse(service: &Service, plan: Plan) -> anyhow::Result<()> {
    let name = plan.files.first().map(|file| file.path.clone()).unwrap_or_default();
    eprintln!("sending {name}");
    let job = service.submit(plan.files).await?;
    let end = service.follow(&job).await?;
    if end["state"] != "succeeded" {
        let detail = end["error"]["detail"].as_str().unwrap_or("it did not say why");
        anyhow::bail!("{name}: {detail} [{}]", end["error"]["code"].as_str().unwrap_or("canceled"));
    }
    let zip = service.get(&format!("/v1/jobs/{job}/bundle")).await?;
    let files = unpack(&zip)?;
    let folder = plan.out.join("bundle");
    bundle::write_folder(&files, &folder)?;
    if let Some(sheet) = files.iter().find(|file| file.path == "preview.png") {
        fs::write(plan.out.join("sheet.png"), &sheet.bytes)?;
    }
    let report = service.get(&format!("/v1/jobs/{job}/report")).await?;
    let report: Report = serde_json::from_slice(&report).context("the report")?;
    tell(&plan.out, &report, &end);
    Ok(())
}

fn tell(out: &Path, report: &Report, job: &Value) {
    println!("{}", before_and_after(report));
    println!("bundle  {}", out.join("bundle").display());
    println!("model   {}", out.join("bundle/asset.glb").display());
    match job["preview"]["failure"].as_str() {
        None => println!("picture {}", out.join("sheet.png").display()),
        Some(reason) => println!("picture none: {reason}"),
    }
}

struct Service {
    client: Client,
    base: String,
}

impl Service {
    async fn submit(&self, files: Vec<SentFile>) -> anyhow::Result<String> {
        let form = files.into_iter().enumerate().fold(Form::new(), |form, (index, file)| {
            let part = Part::bytes(file.bytes).file_name(file.path);
            form.part(if index == 0 { "model" } else { "files" }, part)
        });
        let response = self.client.post(format!("{}/v1/jobs", self.base)).multipart(form).send().await?;
        let status = response.status();
        let answer: Value = response.json().await?;
        let id = answer["id"].as_str().map(str::to_owned);
        id.with_context(|| {
            format!("refused with {status}: {}", answer["detail"].as_str().unwrap_or_default())
        })
    }

    /// Shows progress until the job has ended, and returns it.
    async fn follow(&self, job: &str) -> anyhow::Result<Value> {
        let bar = bar("converting".to_owned());
        let url = format!("{}/v1/jobs/{job}/events", self.base);
        let mut body = self.client.get(url).send().await?.error_for_status()?.bytes_stream();
        let mut pending = Vec::new();
        while let Some(piece) = body.next().await {
            pending.extend_from_slice(&piece?);
            anyhow::ensure!(pending.len() <= LONGEST_EVENT_BYTES, "an event without an end");
            while let Some(end) = pending.windows(2).position(|pair| pair == b"\n\n") {
                let event: Vec<u8> = pending.drain(..end + 2).collect();
                let (name, data) = parse_event(&String::from_utf8_lossy(&event));
                match name.as_str() {
                    "progress" => {
                        bar.set_position(data["percent"].as_u64().unwrap_or(0));
                        bar.set_message(data["stage"].as_str().unwrap_or_default().to_owned());
                    }
                    "done" => {
                        bar.finish_and_clear();
                        return Ok(data);
                    }
                    _ => {}
                }
            }
        }
        anyhow::bail!("the events ended before the job")
    }

    async fn get(&self, path: &str) -> anyhow::Result<Vec<u8>> {
        let request = self.client.get(format!("{}{path}", self.base)).timeout(Duration::from_secs(120));
        Ok(request.send().await?.error_for_status()?.bytes().await?.to_vec())
    }
}

/// Name and data of a server-sent event.
fn parse_event(text: &str) -> (String, Value) {
    let field = |name: &str| {
        text.lines()
            .find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))
            .unwrap_or_default()
            .trim_start()
    };
    (field("event").to_owned(), serde_json::from_str(field("data")).unwrap_or_default())
}

/// The files of a bundle's zip.
fn unpack(zip: &[u8]) -> anyhow::Result<Vec<BundleFile>> {
    let mut archive = zip::ZipArchive::new(Cursor::new(zip))?;
    (0..archive.len())
        .map(|index| {
            let mut entry = archive.by_index(index)?;
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes)?;
            Ok(BundleFile { path: entry.name()?.into_owned(), bytes })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_read_field_by_field() {
        let (name, data) = parse_event("id: 3\nevent: progress\ndata: {\"percent\":7}\n\n");
        assert_eq!((name.as_str(), data["percent"].as_u64()), ("progress", Some(7)));
        assert_eq!(parse_event(": still here\n\n").0, "");
    }
}

//! Receiving a model: multipart parts or a raw body go to disk while they come in, under names of our
//! own. What the client called them is data, never a path.

use std::time::Duration;

use axum::body::Body;
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use futures_util::{Stream, StreamExt};
use multer::{Field, Multipart};
use serde_json::Value;
use sha2::{Digest, Sha256};
use tokio::fs::File;
use tokio::io::AsyncWriteExt;
use tokio::time::timeout;
use uuid::Uuid;

use super::extract::{Parameters, text};
use super::problem::queue_full;
use super::upload_body::{BodyFault, CountedBody, compare_digests, promised_digest};
use super::{App, Problem};
use crate::jobs::folder::InputFolder;
use crate::jobs::model::{JobId, JobInput, JobKind, JobOptions, NewJob, StoredFile};
use crate::jobs::runner::hex;
use crate::settings::Settings;

/// Content types of a raw body, and the name that such a model gets.
pub const RAW_TYPES: [(&str, &str); 6] = [
    ("model/gltf-binary", "model.glb"),
    ("model/gltf+json", "model.gltf"),
    ("model/obj", "model.obj"),
    ("model/ply", "model.ply"),
    ("application/zip", "model.zip"),
    ("application/octet-stream", "model"),
];

/// Receives an upload and puts it into the queue. The job is durable when this returns.
pub async fn accept(
    app: &App,
    kind: JobKind,
    parameters: Parameters,
    headers: &HeaderMap,
    body: Body,
) -> Result<JobId, Problem> {
    refuse_early(app, headers).await?;
    let Ok(_permit) = app.uploads.try_acquire() else {
        let limit = app.settings.max_concurrent_uploads;
        let detail = format!("{limit} uploads are being received (MESHCOLOR_MAX_CONCURRENT_UPLOADS)");
        return Err(Problem::new("too_many_uploads", detail).limit(limit, None).retry(1).closing());
    };
    let id = JobId::new();
    let folder = app.queue.folder.begin_input(id).map_err(|error| Problem::storage(&error).closing())?;
    let mut receiver = Receiver { settings: &app.settings, folder, files: Vec::new(), options: None };
    let seconds = app.settings.upload_timeout_seconds;
    let received = timeout(Duration::from_secs(seconds), receiver.receive(parameters, headers, body));
    let options = received.await.unwrap_or_else(|_| {
        let detail = format!("the upload took more than {seconds} seconds (MESHCOLOR_UPLOAD_TIMEOUT)");
        Err(Problem::new("upload_too_slow", detail).limit(seconds, None).closing())
    })?;
    let Receiver { folder, files, .. } = receiver;
    folder.flush().map_err(|error| Problem::storage(&error))?;
    let job = NewJob { id, kind, input: JobInput { files }, options };
    // A task of its own: a client that leaves now cannot split the row from its files.
    let queue = app.queue.clone();
    tokio::spawn(async move { queue.submit(job, folder).await }).await.map_err(Problem::internal)??;
    Ok(id)
}

/// Whatever can be refused without reading the body.
async fn refuse_early(app: &App, headers: &HeaderMap) -> Result<(), Problem> {
    if app.queue.is_closing() {
        return Err(Problem::new("shutting_down", "the service is stopping; send it again")
            .retry(5)
            .closing());
    }
    let limit = app.settings.max_body_bytes;
    let declared = text(headers, header::CONTENT_LENGTH).and_then(|length| length.parse::<u64>().ok());
    if let Some(actual) = declared.filter(|length| *length > limit) {
        return Err(Problem::from(BodyFault::TooLarge { limit }).limit(limit, Some(actual)));
    }
    if app.queue.is_full().await? {
        return Err(queue_full(app.queue.queue_max()).closing());
    }
    Ok(())
}

struct Receiver<'a> {
    settings: &'a Settings,
    folder: InputFolder,
    /// The model first, in the end.
    files: Vec<StoredFile>,
    options: Option<JobOptions>,
}

impl Receiver<'_> {
    async fn receive(
        &mut self,
        mut parameters: Parameters,
        headers: &HeaderMap,
        body: Body,
    ) -> Result<JobOptions, Problem> {
        let options = options_of_query(&mut parameters)?;
        let content_type = text(headers, header::CONTENT_TYPE).unwrap_or_default();
        let media_type = content_type.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
        let raw = RAW_TYPES.iter().find(|(name, _)| *name == media_type);
        if raw.is_none() && media_type != "multipart/form-data" {
            let names: Vec<_> = RAW_TYPES.iter().map(|(name, _)| *name).collect();
            let detail = format!(
                "Content-Type is \"{media_type}\"; allowed: multipart/form-data, {}",
                names.join(", ")
            );
            return Err(Problem::new("unsupported_media_type", detail).closing());
        }
        let promised = promised_digest(headers)?;
        let mut body = CountedBody::new(body, self.settings, promised.is_some());
        match raw {
            Some((_, name)) => {
                let file = self
                    .store((*name).to_owned(), (&mut body).map(|piece| piece.map_err(Problem::from)))
                    .await?;
                if file.bytes == 0 {
                    return Err(Problem::new("missing_part", "the body is empty; it has to be a model"));
                }
                self.files.push(file);
            }
            None => self.receive_parts(content_type, &mut body).await?,
        }
        compare_digests(promised, body.finish().await?)?;
        Ok(self.options.take().unwrap_or(options))
    }

    async fn receive_parts(&mut self, content_type: &str, body: &mut CountedBody) -> Result<(), Problem> {
        let boundary =
            multer::parse_boundary(content_type).map_err(|_| malformed("Content-Type names no boundary"))?;
        let header = body.header_meter();
        let mut parts = Multipart::new(body, boundary);
        let mut model = None;
        let mut part_count: u64 = 0;
        loop {
            header.start();
            let part = parts.next_field().await.map_err(part_problem)?;
            header.stop();
            let Some(part) = part else { break };
            part_count += 1;
            self.check_part(&part, part_count)?;
            match part.name().unwrap_or_default() {
                "model" => {
                    if model.is_some() {
                        return Err(malformed("there are two parts \"model\"; there has to be exactly one"));
                    }
                    let name = model_name(part.file_name().unwrap_or_default());
                    model = Some(self.store(name, part.map(part_result)).await?);
                }
                "files" => self.receive_sidecar(part).await?,
                "options" => self.receive_options(part).await?,
                other => {
                    let detail = format!("there is no part {other:?}; there are: model, files, options");
                    return Err(malformed(&detail));
                }
            }
        }
        let Some(model) = model else {
            return Err(Problem::new(
                "missing_part",
                "the part \"model\" is missing; curl sends it with -F model=@chair.glb",
            ));
        };
        if let Some(twin) = self.files.iter().find(|file| file.path == model.path) {
            return Err(malformed(&format!("two files are named {:?}", twin.path)));
        }
        self.files.insert(0, model);
        Ok(())
    }

    fn check_part(&self, part: &Field<'_>, part_count: u64) -> Result<(), Problem> {
        let limit = self.settings.max_part_header_bytes;
        let bytes: usize =
            part.headers().iter().map(|(name, value)| name.as_str().len() + value.len() + 4).sum();
        if bytes as u64 > limit {
            return Err(BodyFault::HeaderTooLarge { limit }.into());
        }
        // Every file, and the options beside them.
        let limit = self.settings.limits.files;
        if part_count > limit.saturating_add(1) {
            let detail = format!("the upload has more than {limit} files (MESHCOLOR_MAX_FILES)");
            return Err(Problem::new("too_many_files", detail).limit(limit, None).closing());
        }
        Ok(())
    }

    async fn receive_sidecar(&mut self, part: Field<'_>) -> Result<(), Problem> {
        let path = part.file_name().unwrap_or_default().to_owned();
        if path.is_empty() {
            return Err(malformed("a part \"files\" has no filename; it is the path that the model uses"));
        }
        if self.files.iter().any(|file| file.path == path) {
            return Err(malformed(&format!("two files are named {path:?}")));
        }
        let file = self.store(path, part.map(part_result)).await?;
        self.files.push(file);
        Ok(())
    }

    async fn receive_options(&mut self, mut part: Field<'_>) -> Result<(), Problem> {
        if self.options.is_some() {
            return Err(malformed("there are two parts \"options\"; there may be one"));
        }
        let limit = self.settings.max_options_bytes;
        let mut text = Vec::new();
        while let Some(piece) = part.chunk().await.map_err(part_problem)? {
            text.extend_from_slice(&piece);
            if text.len() as u64 > limit {
                let detail =
                    format!("the options are larger than {limit} bytes (MESHCOLOR_MAX_OPTIONS_BYTES)");
                return Err(Problem::new("body_too_large", detail).limit(limit, None).closing());
            }
        }
        let Ok(Value::Object(object)) = serde_json::from_slice(&text) else {
            return Err(Problem::new("invalid_options", "the options are not a JSON object").closing());
        };
        self.options = Some(JobOptions::from_json(&object).map_err(Problem::from)?);
        Ok(())
    }

    /// Streams one file to disk under a name of our own.
    async fn store(
        &self,
        path: String,
        mut data: impl Stream<Item = Result<Bytes, Problem>> + Unpin,
    ) -> Result<StoredFile, Problem> {
        let stored = Uuid::new_v4().simple().to_string();
        let storage = |error: std::io::Error| Problem::storage(&error).closing();
        let mut file = File::create_new(self.folder.path().join(&stored)).await.map_err(storage)?;
        let (mut bytes, mut hash) = (0, Sha256::new());
        while let Some(piece) = data.next().await {
            let piece = piece?;
            bytes += piece.len() as u64;
            hash.update(&piece);
            file.write_all(&piece).await.map_err(storage)?;
        }
        file.sync_all().await.map_err(storage)?;
        Ok(StoredFile { path, stored, bytes, sha256: hex(&hash.finalize()) })
    }
}

fn options_of_query(parameters: &mut Parameters) -> Result<JobOptions, Problem> {
    let mut options = JobOptions::default();
    let mut named: Vec<_> = parameters.rest().iter().collect();
    // A preset sets every rung, so it goes first.
    named.sort_by_key(|(name, _)| *name != "quality");
    for (name, value) in named {
        options.set(name, value)?;
    }
    options.conversion.check()?;
    Ok(options)
}

/// The name that the model's own URIs are relative to: what was sent where it is a plain relative path,
/// else its last component.
fn model_name(sent: &str) -> String {
    let is_plain = |part: &str| !part.is_empty() && part != "." && part != "..";
    let has_controls = sent.chars().any(char::is_control);
    if !has_controls && !sent.contains(['\\', ':']) && sent.split('/').all(is_plain) {
        return sent.to_owned();
    }
    let last = sent.rsplit(['/', '\\', ':']).next().unwrap_or_default();
    let name: String = last.chars().filter(|c| !c.is_control()).collect();
    if is_plain(&name) { name } else { "model".to_owned() }
}

fn malformed(detail: &str) -> Problem {
    Problem::new("malformed_multipart", detail).closing()
}

fn part_result(piece: multer::Result<Bytes>) -> Result<Bytes, Problem> {
    piece.map_err(part_problem)
}

fn part_problem(error: multer::Error) -> Problem {
    match error {
        multer::Error::StreamReadFailed(cause) => match cause.downcast_ref::<BodyFault>() {
            Some(fault) => fault.clone().into(),
            None => BodyFault::BrokenOff.into(),
        },
        multer::Error::IncompleteHeaders
        | multer::Error::IncompleteStream
        | multer::Error::IncompleteFieldData { .. } => malformed("the body ends inside a part"),
        other => malformed(&other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::model_name;

    #[test]
    fn names_of_models_are_plain_relative_paths() {
        let cases = [
            ("chair.glb", "chair.glb"),
            ("tex/chair.gltf", "tex/chair.gltf"),
            ("../../chair.glb", "chair.glb"),
            ("C:\\x\\chair.glb", "chair.glb"),
            ("\\\\host\\chair.glb", "chair.glb"),
            ("/etc/passwd", "passwd"),
            ("", "model"),
            ("..", "model"),
            ("a\r\nb.glb", "ab.glb"),
            ("A..B.glb", "A..B.glb"),
            ("Stühle 椅子.glb", "Stühle 椅子.glb"),
        ];
        for (sent, expected) in cases {
            assert_eq!(model_name(sent), expected, "{sent:?}");
        }
    }
}

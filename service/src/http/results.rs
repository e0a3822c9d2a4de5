//! What a job left: the bundle, the report, the picture.

use std::io::{Cursor, SeekFrom};
use std::path::PathBuf;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use image::ImageFormat;
use image::imageops::FilterType;
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncSeekExt};
use tokio_util::io::ReaderStream;

use super::extract::{JobPath, Parameters, matches_tag, no_such_job, text};
use super::representation::header_value;
use super::{App, Problem};
use crate::jobs::folder::{BUNDLE_FILE, PREVIEW_FILE, REPORT_FILE};
use crate::jobs::model::{JobId, JobRecord, JobResult, JobState, ResultFile};

/// Results never change: an id is never used again.
const FOREVER: HeaderValue = HeaderValue::from_static("private, max-age=31536000, immutable");

/// Longer sides of thumbnails; a fixed list, so that nobody can ask for a million pictures.
const PREVIEW_SIDES: [u32; 5] = [64, 128, 256, 512, 1024];

/// The job and its result.
async fn finished(app: &App, id: JobId) -> Result<(JobRecord, JobResult), Problem> {
    let mut record = app.queue.store.get(id).await?.ok_or_else(no_such_job)?;
    match (record.state, record.result.take(), record.error.take()) {
        (JobState::Succeeded, Some(result), _) => Ok((record, result)),
        (JobState::Failed, _, error) => {
            let reason = error.map(|error| format!(": {}", error.detail)).unwrap_or_default();
            Err(Problem::new("not_succeeded", format!("the job failed{reason}")))
        }
        (JobState::Canceled, ..) => Err(Problem::new("not_succeeded", "the job was canceled")),
        (state, ..) => {
            let detail = format!("the job is {}; wait for it with Prefer: wait=30 on the job", state.name());
            Err(Problem::new("not_finished", detail).retry(1))
        }
    }
}

/// The bundle as a zip file.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/bundle", tag = "results",
    params(
        ("id" = String, Path, description = "The job"),
        ("Range" = Option<String>, Header, description = "One range of bytes"),
        ("If-Range" = Option<String>, Header, description = "The tag that the range belongs to"),
        ("If-None-Match" = Option<String>, Header, description = "The tag that the client has"),
    ),
    responses(
        (status = 200, description = "The bundle", body = Vec<u8>, content_type = "application/zip"),
        (status = 206, description = "A part of it", body = Vec<u8>, content_type = "application/zip"),
        (status = 304, description = "As the client has it"),
        (status = 404, description = "No such job, or a check", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It has no result, or none yet", body = Problem, content_type = "application/problem+json"),
        (status = 416, description = "The range lies outside", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn bundle(
    State(app): State<Arc<App>>,
    JobPath(id): JobPath,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    bundle_response(&app, id, &headers).await
}

/// The bundle of a job that has succeeded.
pub async fn bundle_response(app: &App, id: JobId, headers: &HeaderMap) -> Result<Response, Problem> {
    let (record, result) = finished(app, id).await?;
    let file = result
        .bundle
        .ok_or_else(|| Problem::new("not_found", "this job is a check: it has a report and no bundle"))?;
    let model = record.input.files.first().map(|file| file.path.as_str()).unwrap_or_default();
    let name = download_name(model);
    let mut response = serve(app.queue.folder.result(id, BUNDLE_FILE), &file, headers).await?;
    if response.status().is_success() {
        let out = response.headers_mut();
        out.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/zip"));
        out.insert(header::CONTENT_DISPOSITION, content_disposition(&name));
    }
    Ok(response)
}

/// Serves a file with its strong tag, whole or one range of it.
async fn serve(path: PathBuf, file: &ResultFile, headers: &HeaderMap) -> Result<Response, Problem> {
    let tag = format!("\"{}\"", file.sha256);
    let common = [
        (header::ETAG, header_value(&tag)),
        (header::CACHE_CONTROL, FOREVER),
        (header::ACCEPT_RANGES, HeaderValue::from_static("bytes")),
    ];
    if matches_tag(headers, &tag) {
        return Ok((StatusCode::NOT_MODIFIED, common).into_response());
    }
    // A range of another version is answered with the whole.
    let is_same = text(headers, header::IF_RANGE).is_none_or(|other| other == tag);
    let range = text(headers, header::RANGE).filter(|_| is_same).map(|text| parse_range(text, file.bytes));
    let (status, start, length) = match range {
        None | Some(Range::Ignored) => (StatusCode::OK, 0, file.bytes),
        Some(Range::Within(start, length)) => (StatusCode::PARTIAL_CONTENT, start, length),
        Some(Range::Outside) => {
            let detail = format!("the file has {} bytes", file.bytes);
            let mut response = Problem::new("range_not_satisfiable", detail).into_response();
            let whole = header_value(&format!("bytes */{}", file.bytes));
            response.headers_mut().insert(header::CONTENT_RANGE, whole);
            return Ok(response);
        }
    };
    let mut opened = File::open(&path).await.map_err(|error| gone_or_broken(&error))?;
    opened.seek(SeekFrom::Start(start)).await.map_err(Problem::internal)?;
    let body = Body::from_stream(ReaderStream::with_capacity(opened.take(length), 64 << 10));
    let mut response = (status, common, body).into_response();
    let out = response.headers_mut();
    out.insert(header::CONTENT_LENGTH, HeaderValue::from(length));
    if status == StatusCode::PARTIAL_CONTENT {
        let place = format!("bytes {start}-{}/{}", start + length - 1, file.bytes);
        out.insert(header::CONTENT_RANGE, header_value(&place));
    }
    Ok(response)
}

/// A job may be deleted between the look at it and the opening of its file.
fn gone_or_broken(error: &std::io::Error) -> Problem {
    match error.kind() {
        std::io::ErrorKind::NotFound => no_such_job(),
        _ => Problem::internal(error),
    }
}

#[derive(Debug, PartialEq, Eq)]
enum Range {
    /// Start and length, at least one byte.
    Within(u64, u64),
    Outside,
    /// Not one range of bytes; RFC 9110 14.2 lets a server answer with the whole.
    Ignored,
}

fn parse_range(text: &str, bytes: u64) -> Range {
    let Some((first, last)) = text.strip_prefix("bytes=").and_then(|range| range.split_once('-')) else {
        return Range::Ignored;
    };
    let within = |start: u64, end: u64| {
        if start < bytes { Range::Within(start, end.min(bytes - 1) - start + 1) } else { Range::Outside }
    };
    match (first.trim().parse::<u64>(), last.trim().parse::<u64>()) {
        (Ok(start), Ok(end)) if start <= end => within(start, end),
        (Ok(start), Err(_)) if last.trim().is_empty() => within(start, u64::MAX),
        (Err(_), Ok(0)) if first.trim().is_empty() => Range::Outside,
        (Err(_), Ok(suffix)) if first.trim().is_empty() => within(bytes.saturating_sub(suffix), u64::MAX),
        _ => Range::Ignored,
    }
}

/// `chair.glb` comes back as `chair-meshcolor.zip`.
fn download_name(model: &str) -> String {
    let last = model.rsplit('/').next().unwrap_or_default();
    let stem = last.rsplit_once('.').map_or(last, |(stem, _)| stem);
    let stem: String = stem.chars().take(100).collect();
    if stem.is_empty() { "meshcolor.zip".to_owned() } else { format!("{stem}-meshcolor.zip") }
}

/// The header for any name: a plain form for old clients, the exact one percent-encoded (RFC 6266).
fn content_disposition(name: &str) -> HeaderValue {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    let plain: String = name.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
    let exact: String =
        name.bytes()
            .map(|byte| {
                if is_plain(char::from(byte)) { char::from(byte).to_string() } else { format!("%{byte:02X}") }
            })
            .collect();
    header_value(&format!("attachment; filename=\"{plain}\"; filename*=UTF-8''{exact}"))
}

/// The report as JSON.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/report", tag = "results",
    params(
        ("id" = String, Path, description = "The job"),
        ("format" = Option<String>, Query, description = "`json`"),
    ),
    responses(
        (status = 200, description = "The report", body = Object, content_type = "application/json"),
        (status = 304, description = "As the client has it"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 406, description = "Another format than JSON", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It has no result, or none yet", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn report(
    State(app): State<Arc<App>>,
    JobPath(id): JobPath,
    mut parameters: Parameters,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = parameters.take("format");
    parameters.finish("format")?;
    let is_offered = match &format {
        Some(format) => format == "json",
        None => accepts_json(&headers),
    };
    if !is_offered {
        return Err(Problem::new("not_acceptable", "the report comes as application/json"));
    }
    report_response(&app, id, &headers).await
}

/// The report of a job that has succeeded.
pub async fn report_response(app: &App, id: JobId, headers: &HeaderMap) -> Result<Response, Problem> {
    finished(app, id).await?;
    let path = app.queue.folder.result(id, REPORT_FILE);
    let bytes = tokio::fs::read(path).await.map_err(|error| gone_or_broken(&error))?;
    tagged_bytes(bytes, "application/json", headers)
}

fn tagged_bytes(
    bytes: Vec<u8>,
    content_type: &'static str,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let tag = format!("\"{}\"", blake3::hash(&bytes).to_hex());
    let common = [(header::ETAG, header_value(&tag)), (header::CACHE_CONTROL, FOREVER)];
    if matches_tag(headers, &tag) {
        return Ok((StatusCode::NOT_MODIFIED, common).into_response());
    }
    let kind = [(header::CONTENT_TYPE, HeaderValue::from_static(content_type))];
    Ok((kind, common, bytes).into_response())
}

fn accepts_json(headers: &HeaderMap) -> bool {
    let Some(accept) = text(headers, header::ACCEPT) else { return true };
    accept
        .split(',')
        .map(|range| range.split(';').next().unwrap_or_default().trim())
        .any(|range| matches!(range, "*/*" | "application/*" | "application/json"))
}

/// The seam-check sheet.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/preview.png", tag = "results",
    params(
        ("id" = String, Path, description = "The job"),
        ("size" = Option<u32>, Query, description = "Longer side of a thumbnail: 64, 128, 256, 512 or 1024"),
    ),
    responses(
        (status = 200, description = "The picture", body = Vec<u8>, content_type = "image/png"),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A size that is not offered", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job, or no picture", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It has no result, or none yet", body = Problem, content_type = "application/problem+json"),
        (status = "5XX", description = "Our fault", body = Problem, content_type = "application/problem+json"),
    ),
)]
pub async fn preview(
    State(app): State<Arc<App>>,
    JobPath(id): JobPath,
    mut parameters: Parameters,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let side = match parameters.take("size") {
        None => None,
        Some(size) => {
            let side = size.parse().ok().filter(|side| PREVIEW_SIDES.contains(side));
            Some(side.ok_or_else(|| {
                let sides: Vec<_> = PREVIEW_SIDES.iter().map(u32::to_string).collect();
                Problem::new(
                    "invalid_parameter",
                    format!("size is not offered; there are: {}", sides.join(", ")),
                )
            })?)
        }
    };
    parameters.finish("size")?;
    let (_, result) = finished(&app, id).await?;
    if result.preview.is_none() {
        let detail = match result.preview_failure {
            Some(reason) => format!("the picture could not be drawn: {reason}"),
            None => "no picture was asked for".to_owned(),
        };
        return Err(Problem::new("not_found", detail));
    }
    let path = app.queue.folder.result(id, PREVIEW_FILE);
    let png = tokio::fs::read(path).await.map_err(|error| gone_or_broken(&error))?;
    let bytes = match side {
        None => png,
        Some(side) => tokio::task::spawn_blocking(move || thumbnail(&png, side))
            .await
            .map_err(Problem::internal)?
            .map_err(Problem::internal)?,
    };
    tagged_bytes(bytes, "image/png", &headers)
}

/// A smaller copy whose longer side is `side`; a smaller picture stays as it is.
fn thumbnail(png: &[u8], side: u32) -> image::ImageResult<Vec<u8>> {
    let picture = image::load_from_memory_with_format(png, ImageFormat::Png)?;
    if picture.width().max(picture.height()) <= side {
        return Ok(png.to_vec());
    }
    let mut out = Cursor::new(Vec::new());
    picture.resize(side, side, FilterType::CatmullRom).write_to(&mut out, ImageFormat::Png)?;
    Ok(out.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_one_span_of_bytes_or_the_whole() {
        let cases = [
            ("bytes=0-0", Range::Within(0, 1)),
            ("bytes=2-4", Range::Within(2, 3)),
            ("bytes=2-", Range::Within(2, 8)),
            ("bytes=-3", Range::Within(7, 3)),
            ("bytes=-30", Range::Within(0, 10)),
            ("bytes=5-99", Range::Within(5, 5)),
            ("bytes=10-", Range::Outside),
            ("bytes=-0", Range::Outside),
            ("bytes=4-2", Range::Ignored),
            ("bytes=0-1,3-4", Range::Ignored),
            ("bytes=a-b", Range::Ignored),
            ("lines=0-1", Range::Ignored),
        ];
        for (text, expected) in cases {
            assert_eq!(parse_range(text, 10), expected, "{text}");
        }
        assert_eq!(parse_range("bytes=0-", 0), Range::Outside);
    }

    #[test]
    fn names_in_headers_are_safe() {
        assert_eq!(download_name("tex/chair.glb"), "chair-meshcolor.zip");
        assert_eq!(download_name(""), "meshcolor.zip");
        let header = content_disposition("stühle\"\r\nX: y.zip");
        assert_eq!(
            header.to_str().unwrap(),
            "attachment; filename=\"st_hle___X__y.zip\"; filename*=UTF-8''st%C3%BChle%22%0D%0AX%3A%20y.zip"
        );
    }

    #[test]
    fn thumbnails_keep_the_aspect_and_never_grow() {
        let mut png = Cursor::new(Vec::new());
        image::RgbImage::new(200, 100).write_to(&mut png, ImageFormat::Png).unwrap();
        let small = image::load_from_memory(&thumbnail(png.get_ref(), 64).unwrap()).unwrap();
        assert_eq!((small.width(), small.height()), (64, 32));
        assert_eq!(&thumbnail(png.get_ref(), 256).unwrap(), png.get_ref());
    }
}

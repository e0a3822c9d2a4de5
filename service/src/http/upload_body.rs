//! A request body that is counted, hashed and timed while it is read, so that nothing downstream can
//! take more than is allowed, whatever the headers said.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, BodyDataStream};
use axum::http::HeaderMap;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use futures_util::{Stream, StreamExt};
use sha2::{Digest, Sha256};
use tokio::time::{Instant, Sleep, sleep};

use super::Problem;
use super::extract::text;
use crate::settings::Settings;

/// A part's header may come in one piece with the data behind it; a piece is never larger than this.
const PIECE_BYTES: u64 = 512 << 10;

/// Why a body ended early.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BodyFault {
    #[error("the body is larger than {limit} bytes")]
    TooLarge { limit: u64 },
    #[error("a part's header is larger than {limit} bytes")]
    HeaderTooLarge { limit: u64 },
    #[error("nothing came for {seconds} seconds")]
    TooSlow { seconds: u64 },
    #[error("the body broke off")]
    BrokenOff,
}

impl From<BodyFault> for Problem {
    fn from(fault: BodyFault) -> Self {
        match fault {
            BodyFault::TooLarge { limit } => Self::new(
                "body_too_large",
                format!("the body is larger than {limit} bytes. The operator raises it with MESHCOLOR_MAX_BODY_BYTES."),
            )
            .limit(limit, None),
            BodyFault::HeaderTooLarge { limit } => Self::new(
                "malformed_multipart",
                format!("a part's header is larger than {limit} bytes (MESHCOLOR_MAX_PART_HEADER_BYTES)"),
            )
            .limit(limit, None),
            BodyFault::TooSlow { seconds } => Self::new(
                "upload_too_slow",
                format!("nothing came for {seconds} seconds (MESHCOLOR_BODY_IDLE_TIMEOUT)"),
            )
            .limit(seconds, None),
            BodyFault::BrokenOff => Self::new("incomplete_body", "the body broke off before its end"),
        }
        .closing()
    }
}

/// Counts the bytes that come while a part's header is awaited.
#[derive(Clone, Debug, Default)]
pub struct HeaderMeter(Arc<AtomicU64>);

/// The value of a meter that is off.
const OFF: u64 = u64::MAX;

impl HeaderMeter {
    pub fn start(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    pub fn stop(&self) {
        self.0.store(OFF, Ordering::Relaxed);
    }

    fn add(&self, bytes: u64) {
        let count = self.0.load(Ordering::Relaxed);
        if count != OFF {
            self.0.store(count.saturating_add(bytes).min(OFF - 1), Ordering::Relaxed);
        }
    }

    fn exceeds(&self, limit: u64) -> bool {
        let count = self.0.load(Ordering::Relaxed);
        count != OFF && count > limit
    }
}

/// See the module.
pub struct CountedBody {
    inner: BodyDataStream,
    limit: u64,
    bytes: u64,
    header_limit: u64,
    header: HeaderMeter,
    idle: Duration,
    silence: Pin<Box<Sleep>>,
    hash: Option<Sha256>,
    /// Readers that take all that is ready would hold a whole upload in memory; after every piece they
    /// are sent away once, so that they use what they have.
    rests: bool,
}

impl CountedBody {
    pub fn new(body: Body, settings: &Settings, hashes: bool) -> Self {
        let idle = Duration::from_secs(settings.body_idle_timeout_seconds);
        let header = HeaderMeter::default();
        header.stop();
        Self {
            inner: body.into_data_stream(),
            limit: settings.max_body_bytes,
            bytes: 0,
            header_limit: settings.max_part_header_bytes,
            header,
            idle,
            silence: Box::pin(sleep(idle)),
            hash: hashes.then(Sha256::new),
            rests: false,
        }
    }

    pub fn header_meter(&self) -> HeaderMeter {
        self.header.clone()
    }

    /// Reads what is left and returns the hash of the whole body, if one was asked for.
    pub async fn finish(mut self) -> Result<Option<[u8; 32]>, BodyFault> {
        while let Some(piece) = self.next().await {
            piece?;
        }
        Ok(self.hash.map(|hash| hash.finalize().into()))
    }

    fn accept(&mut self, piece: &Bytes) -> Result<(), BodyFault> {
        self.bytes += piece.len() as u64;
        if self.bytes > self.limit {
            return Err(BodyFault::TooLarge { limit: self.limit });
        }
        self.header.add(piece.len() as u64);
        if let Some(hash) = &mut self.hash {
            hash.update(piece);
        }
        let deadline = Instant::now() + self.idle;
        self.silence.as_mut().reset(deadline);
        self.rests = true;
        Ok(())
    }
}

impl Stream for CountedBody {
    type Item = Result<Bytes, BodyFault>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let this = &mut *self;
        if std::mem::take(&mut this.rests) {
            context.waker().wake_by_ref();
            return Poll::Pending;
        }
        if this.header.exceeds(this.header_limit + PIECE_BYTES) {
            return Poll::Ready(Some(Err(BodyFault::HeaderTooLarge { limit: this.header_limit })));
        }
        match this.inner.poll_next_unpin(context) {
            Poll::Ready(Some(Ok(piece))) => Poll::Ready(Some(this.accept(&piece).map(|()| piece))),
            Poll::Ready(Some(Err(_))) => Poll::Ready(Some(Err(BodyFault::BrokenOff))),
            Poll::Ready(None) => Poll::Ready(None),
            Poll::Pending => match this.silence.as_mut().poll(context) {
                Poll::Ready(()) => {
                    Poll::Ready(Some(Err(BodyFault::TooSlow { seconds: this.idle.as_secs() })))
                }
                Poll::Pending => Poll::Pending,
            },
        }
    }
}

/// The SHA-256 that `Content-Digest` (RFC 9530) promises, if it names one.
pub fn promised_digest(headers: &HeaderMap) -> Result<Option<[u8; 32]>, Problem> {
    let Some(value) = text(headers, axum::http::HeaderName::from_static("content-digest")) else {
        return Ok(None);
    };
    let Some(encoded) = value.split(',').find_map(|item| item.trim().strip_prefix("sha-256=")) else {
        return Ok(None);
    };
    let bytes = encoded.strip_prefix(':').and_then(|rest| rest.strip_suffix(':'));
    bytes
        .and_then(|bytes| STANDARD.decode(bytes).ok())
        .and_then(|bytes| <[u8; 32]>::try_from(bytes).ok())
        .map(Some)
        .ok_or_else(|| {
            Problem::new("digest_mismatch", "Content-Digest is not of the form sha-256=:BASE64 OF 32 BYTES:")
                .closing()
        })
}

/// Compares what came with what was promised.
pub fn compare_digests(promised: Option<[u8; 32]>, actual: Option<[u8; 32]>) -> Result<(), Problem> {
    match (promised, actual) {
        (Some(promised), Some(actual)) if promised != actual => Err(Problem::new(
            "digest_mismatch",
            format!("the body's digest is sha-256=:{}:", STANDARD.encode(actual)),
        )),
        _ => Ok(()),
    }
}

//! The service as a whole: data folder, queue, listener, and the way down.
//!
//! The accept loop is our own because axum's keeps connections that never send a header: here each has a
//! time for it, and the number of connections is bounded.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, oneshot};
use tracing::{info, warn};

use crate::http::{self, App};
use crate::jobs::folder::DataFolder;
use crate::jobs::queue::{Queue, QueueParts};
use crate::jobs::runner::{InProcess, Runner};
use crate::jobs::sqlite::SqliteStore;
use crate::settings::Settings;
use crate::work;

/// Largest header of a request: lines and fields together.
const LARGEST_HEADER_BYTES: usize = 64 << 10;

/// What `serve` is asked for.
#[derive(Clone, Debug)]
pub struct Config {
    pub bind: SocketAddr,
    pub data: PathBuf,
    pub worker_count: usize,
    pub threads: usize,
    pub settings: Settings,
}

/// A service that runs.
pub struct Server {
    pub address: SocketAddr,
    app: Arc<App>,
    store: Arc<SqliteStore>,
    stop: oneshot::Sender<()>,
    accepting: tokio::task::JoinHandle<()>,
}

impl Server {
    /// Starts with the conversion of this process.
    pub async fn start(config: Config) -> anyhow::Result<Self> {
        let pool = work::thread_pool(config.threads)?;
        let runner = Arc::new(InProcess { pool, limits: config.settings.limits.clone() });
        Self::start_with(config, runner).await
    }

    /// Starts with any runner.
    pub async fn start_with(config: Config, runner: Arc<dyn Runner>) -> anyhow::Result<Self> {
        // Before the database is touched: another process may be using it.
        let folder = Arc::new(DataFolder::open(&config.data)?);
        let store = Arc::new(SqliteStore::open(&folder.database()).await?);
        let listener = TcpListener::bind(config.bind)
            .await
            .with_context(|| format!("cannot listen on {}", config.bind))?;
        let address = listener.local_addr()?;
        let queue = Queue::start(QueueParts {
            store: store.clone(),
            folder,
            runner,
            limits: config.settings.limits.clone(),
            queue_max: config.settings.queue_max,
            worker_count: config.worker_count,
        })
        .await?;
        let app = App::new(queue, config.settings.clone());
        let (stop, stopped) = oneshot::channel();
        let acceptor = Acceptor { listener, router: http::router(app.clone()), settings: config.settings };
        let accepting = tokio::spawn(acceptor.accept(stopped));
        info!(%address, data = %config.data.display(), workers = config.worker_count, threads = config.threads, "serving");
        Ok(Self { address, app, store, stop, accepting })
    }

    /// Stops: no new work, requests in flight are answered, running jobs end or go back into the queue.
    pub async fn stop(self) {
        info!("stopping");
        let grace = Duration::from_secs(self.app.settings.shutdown_grace_seconds);
        self.app.queue.begin_close();
        let _ = self.stop.send(());
        let accepting = async {
            if tokio::time::timeout(grace, self.accepting).await.is_err() {
                warn!("some connections did not end in time");
            }
        };
        tokio::join!(self.app.queue.close(grace), accepting);
        self.store.close().await;
        info!("stopped");
    }
}

struct Acceptor {
    listener: TcpListener,
    router: Router,
    settings: Settings,
}

impl Acceptor {
    async fn accept(self, mut stopped: oneshot::Receiver<()>) {
        let most = usize::try_from(self.settings.max_connections).unwrap_or(usize::MAX);
        let permits = Arc::new(Semaphore::new(most.min(Semaphore::MAX_PERMITS)));
        let graceful = GracefulShutdown::new();
        loop {
            // A connection over the limit waits in the system's backlog.
            let next = async {
                let permit = permits.clone().acquire_owned().await.ok()?;
                Some((permit, self.listener.accept().await))
            };
            let accepted = tokio::select! {
                next = next => next,
                _ = &mut stopped => break,
            };
            match accepted {
                Some((permit, Ok((stream, _)))) => {
                    let connection = graceful.watch(self.connection(stream));
                    tokio::spawn(async move {
                        // Clients that leave or never speak are no events of ours.
                        let _ = connection.await;
                        drop(permit);
                    });
                }
                Some((_, Err(error))) => {
                    // Out of file descriptors, for one; trying again at once would only spin.
                    warn!(%error, "a connection was not accepted");
                    tokio::time::sleep(Duration::from_millis(100)).await;
                }
                None => break,
            }
        }
        drop(self.listener);
        graceful.shutdown().await;
    }

    fn connection(
        &self,
        stream: TcpStream,
    ) -> http1::Connection<TokioIo<TcpStream>, TowerToHyperService<Router>> {
        let _ = stream.set_nodelay(true);
        http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(Duration::from_secs(self.settings.header_read_timeout_seconds))
            .max_header_size(LARGEST_HEADER_BYTES)
            .serve_connection(TokioIo::new(stream), TowerToHyperService::new(self.router.clone()))
    }
}

//! The job store in one SQLite file: write-ahead log, flushed to disk at every commit.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use futures_util::future::FutureExt;
use meshcolor::pipeline::ENGINE_VERSION;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sqlx::sqlite::{
    SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteRow, SqliteSynchronous,
};
use sqlx::{Row, query};

use super::model::{Ending, JobId, JobKind, JobRecord, JobState, NewJob};
use super::store::{CancelOutcome, JobStore, Page, StoreError, StoreFuture};
use crate::clock::Timestamp;

pub struct SqliteStore {
    pool: SqlitePool,
}

impl SqliteStore {
    /// Opens the file, making it and bringing its tables up to date where needed.
    pub async fn open(path: &Path) -> anyhow::Result<Self> {
        let options = SqliteConnectOptions::new()
            .filename(path)
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Full)
            .busy_timeout(Duration::from_secs(10));
        let pool = SqlitePoolOptions::new()
            .max_connections(4)
            .acquire_timeout(Duration::from_secs(10))
            .connect_with(options)
            .await
            .with_context(|| format!("cannot open {}", path.display()))?;
        sqlx::migrate!("./migrations").run(&pool).await.context("cannot bring the job tables up to date")?;
        Ok(Self { pool })
    }

    /// Closes every connection, so that the log is folded into the file.
    pub async fn close(&self) {
        self.pool.close().await;
    }
}

/// Wraps a database call as the trait wants it.
macro_rules! stored {
    ($body:block) => {
        async move {
            let result: anyhow::Result<_> = async move $body.await;
            result.map_err(StoreError::from)
        }
        .boxed()
    };
}

impl JobStore for SqliteStore {
    fn insert<'a>(&'a self, job: &'a NewJob, queue_max: u64) -> StoreFuture<'a, ()> {
        async move {
            let result: anyhow::Result<u64> = async {
                let inserted = query(
                    "INSERT INTO jobs (id, kind, state, created_at, engine_version, input, options)
                     SELECT ?1, ?2, 'queued', ?3, ?4, ?5, ?6
                     WHERE (SELECT COUNT(*) FROM jobs WHERE state = 'queued') < ?7",
                )
                .bind(job.id.to_string())
                .bind(job.kind.name())
                .bind(Timestamp::now().0)
                .bind(ENGINE_VERSION)
                .bind(to_text(&job.input)?)
                .bind(to_text(&job.options.to_json())?)
                .bind(to_integer(queue_max))
                .execute(&self.pool)
                .await?;
                Ok(inserted.rows_affected())
            }
            .await;
            match result? {
                0 => Err(StoreError::QueueFull { limit: queue_max }),
                _ => Ok(()),
            }
        }
        .boxed()
    }

    fn get(&self, id: JobId) -> StoreFuture<'_, Option<JobRecord>> {
        stored!({
            let row =
                query("SELECT * FROM jobs WHERE id = ?").bind(id.to_string()).fetch_optional(&self.pool);
            row.await?.map(|row| record(&row)).transpose()
        })
    }

    fn list(&self, page: Page) -> StoreFuture<'_, Vec<JobRecord>> {
        stored!({
            let rows = query(
                "SELECT * FROM jobs WHERE (?1 IS NULL OR state = ?1) AND (?2 IS NULL OR id < ?2)
                 ORDER BY id DESC LIMIT ?3",
            )
            .bind(page.state.map(JobState::name))
            .bind(page.before.map(|id| id.to_string()))
            .bind(page.size)
            .fetch_all(&self.pool)
            .await?;
            rows.iter().map(record).collect()
        })
    }

    fn ids(&self) -> StoreFuture<'_, Vec<(JobId, JobState)>> {
        stored!({
            let rows = query("SELECT id, state FROM jobs").fetch_all(&self.pool).await?;
            rows.iter().map(|row| Ok((id(row)?, state(row)?))).collect()
        })
    }

    fn queued_count(&self, up_to: Option<JobId>) -> StoreFuture<'_, u64> {
        stored!({
            let row =
                query("SELECT COUNT(*) AS n FROM jobs WHERE state = 'queued' AND (?1 IS NULL OR id <= ?1)")
                    .bind(up_to.map(|id| id.to_string()))
                    .fetch_one(&self.pool)
                    .await?;
            count(&row, "n")
        })
    }

    fn claim(&self) -> StoreFuture<'_, Option<JobRecord>> {
        stored!({
            let rows = query(
                "UPDATE jobs SET state = 'running', started_at = ?, attempt = attempt + 1, revision = revision + 1
                 WHERE state = 'queued'
                   AND id = (SELECT id FROM jobs WHERE state = 'queued' ORDER BY id LIMIT 1)
                 RETURNING *",
            )
            .bind(Timestamp::now().0)
            .fetch_all(&self.pool)
            .await?;
            rows.first().map(record).transpose()
        })
    }

    fn finish<'a>(&'a self, id: JobId, revision: u64, ending: &'a Ending) -> StoreFuture<'a, bool> {
        stored!({
            let (result, error) = match ending {
                Ending::Succeeded(result) => (Some(to_text(result)?), None),
                Ending::Failed(error) => (None, Some(to_text(error)?)),
                Ending::Canceled => (None, None),
            };
            let updated = query(
                "UPDATE jobs SET state = ?, finished_at = ?, result = ?, error = ?, revision = revision + 1
                 WHERE id = ? AND revision = ? AND state = 'running'
                   AND (cancel_requested = 0 OR ? <> 'succeeded')",
            )
            .bind(ending.state().name())
            .bind(Timestamp::now().0)
            .bind(result)
            .bind(error)
            .bind(id.to_string())
            .bind(to_integer(revision))
            .bind(ending.state().name())
            .execute(&self.pool)
            .await?;
            Ok(updated.rows_affected() > 0)
        })
    }

    fn release(&self, id: JobId, revision: u64) -> StoreFuture<'_, bool> {
        stored!({ Ok(self.release_where(Some((id, revision))).await? > 0) })
    }

    fn release_all(&self) -> StoreFuture<'_, u64> {
        stored!({ self.release_where(None).await })
    }

    fn cancel(&self, id: JobId) -> StoreFuture<'_, CancelOutcome> {
        stored!({
            let rows = query(
                "UPDATE jobs SET cancel_requested = 1,
                     revision = revision + (state = 'queued'),
                     finished_at = CASE state WHEN 'queued' THEN ?1 ELSE finished_at END,
                     state = CASE state WHEN 'queued' THEN 'canceled' ELSE state END
                 WHERE id = ?2 AND state IN ('queued', 'running')
                 RETURNING state",
            )
            .bind(Timestamp::now().0)
            .bind(id.to_string())
            .fetch_all(&self.pool)
            .await?;
            Ok(match rows.first().map(state).transpose()? {
                Some(JobState::Canceled) => CancelOutcome::Canceled,
                Some(_) => CancelOutcome::Requested,
                None => CancelOutcome::Nothing,
            })
        })
    }

    fn delete(&self, id: JobId) -> StoreFuture<'_, bool> {
        stored!({
            let deleted =
                query("DELETE FROM jobs WHERE id = ?").bind(id.to_string()).execute(&self.pool).await?;
            Ok(deleted.rows_affected() > 0)
        })
    }
}

impl SqliteStore {
    async fn release_where(&self, one: Option<(JobId, u64)>) -> anyhow::Result<u64> {
        let updated = query(
            "UPDATE jobs SET attempt = attempt - 1, revision = revision + 1,
                 started_at = CASE cancel_requested WHEN 1 THEN started_at END,
                 finished_at = CASE cancel_requested WHEN 1 THEN ?1 END,
                 state = CASE cancel_requested WHEN 1 THEN 'canceled' ELSE 'queued' END
             WHERE state = 'running' AND (?2 IS NULL OR (id = ?2 AND revision = ?3))",
        )
        .bind(Timestamp::now().0)
        .bind(one.map(|(id, _)| id.to_string()))
        .bind(one.map(|(_, revision)| to_integer(revision)))
        .execute(&self.pool)
        .await?;
        Ok(updated.rows_affected())
    }
}

/// SQLite's integers are signed; figures over their range mean "no bound" anyway.
fn to_integer(figure: u64) -> i64 {
    i64::try_from(figure).unwrap_or(i64::MAX)
}

fn to_text(value: &impl Serialize) -> anyhow::Result<String> {
    Ok(serde_json::to_string(value)?)
}

fn from_text<T: DeserializeOwned>(row: &SqliteRow, column: &str) -> anyhow::Result<Option<T>> {
    let text: Option<String> = row.try_get(column)?;
    text.map(|text| serde_json::from_str(&text).with_context(|| format!("column {column}"))).transpose()
}

fn id(row: &SqliteRow) -> anyhow::Result<JobId> {
    Ok(row.try_get::<String, _>("id")?.parse()?)
}

fn state(row: &SqliteRow) -> anyhow::Result<JobState> {
    let name: String = row.try_get("state")?;
    JobState::from_name(&name).with_context(|| format!("unknown state {name}"))
}

fn count(row: &SqliteRow, column: &str) -> anyhow::Result<u64> {
    Ok(u64::try_from(row.try_get::<i64, _>(column)?)?)
}

fn time(row: &SqliteRow, column: &str) -> anyhow::Result<Option<Timestamp>> {
    Ok(row.try_get::<Option<i64>, _>(column)?.map(Timestamp))
}

fn record(row: &SqliteRow) -> anyhow::Result<JobRecord> {
    let kind: String = row.try_get("kind")?;
    Ok(JobRecord {
        id: id(row)?,
        kind: JobKind::from_name(&kind).with_context(|| format!("unknown kind {kind}"))?,
        state: state(row)?,
        created_at: time(row, "created_at")?.context("a job without a creation time")?,
        started_at: time(row, "started_at")?,
        finished_at: time(row, "finished_at")?,
        attempt: u32::try_from(count(row, "attempt")?)?,
        revision: count(row, "revision")?,
        cancel_requested: row.try_get("cancel_requested")?,
        engine_version: row.try_get("engine_version")?,
        input: from_text(row, "input")?.context("a job without input")?,
        options: from_text(row, "options")?.context("a job without options")?,
        result: from_text(row, "result")?,
        error: from_text(row, "error")?,
    })
}

#[cfg(test)]
mod tests;

-- One row for each job. Times are Unix milliseconds; `input`, `options`, `result` and `error` are JSON.
-- `id` is ordered by time, so it is also the queue's order. `revision` counts state changes: it fences
-- writes and numbers events.
CREATE TABLE jobs (
    id               TEXT PRIMARY KEY NOT NULL,
    kind             TEXT NOT NULL CHECK (kind IN ('convert', 'check')),
    state            TEXT NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'canceled')),
    created_at       INTEGER NOT NULL,
    started_at       INTEGER,
    finished_at      INTEGER,
    attempt          INTEGER NOT NULL DEFAULT 0,
    revision         INTEGER NOT NULL DEFAULT 1,
    cancel_requested INTEGER NOT NULL DEFAULT 0,
    engine_version   TEXT NOT NULL,
    input            TEXT NOT NULL,
    options          TEXT NOT NULL,
    result           TEXT,
    error            TEXT
) STRICT;

CREATE INDEX jobs_by_state ON jobs (state, id);

-- A state that ends a job is its last, whatever a program does.
CREATE TRIGGER terminal_states_are_final
BEFORE UPDATE OF state ON jobs
WHEN OLD.state IN ('succeeded', 'failed', 'canceled') AND NEW.state <> OLD.state
BEGIN
    SELECT RAISE(ABORT, 'a terminal state never changes');
END;

"""Many cases: batches, worker processes, shards, resuming, and what a run tells in the end."""

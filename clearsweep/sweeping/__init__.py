"""Many cases: batches, worker processes, shards, resuming, and what a run reports in the end."""

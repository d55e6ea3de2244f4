"""Runs many cases: batches, worker processes, shards, resuming, and the summary of a run."""

"""Runs beyond one machine: nodes of a cluster compute shards of the cases."""

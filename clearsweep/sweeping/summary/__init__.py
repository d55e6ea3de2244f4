"""The summary that a run prints."""

"""One case from its set-up to its end."""

"""What is said and understood in words: errors, units, numbers as people read them, figures of a user's own."""

"""What is known of a case's machine before it moves."""

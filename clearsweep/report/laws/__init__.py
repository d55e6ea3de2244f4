"""Tables and pictures that compare laws with each other."""

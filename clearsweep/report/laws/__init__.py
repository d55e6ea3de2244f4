"""Tables and pictures that compare laws."""

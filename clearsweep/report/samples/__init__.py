"""Tables and sentences on samples of cases: spread, chances, drivers, counts."""

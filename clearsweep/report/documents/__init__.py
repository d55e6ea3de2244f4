"""Files that are written: the page of a run, of one case, of two runs; figures for a paper."""

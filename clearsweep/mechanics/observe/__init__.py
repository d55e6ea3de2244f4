"""What is taken from the motion on its way: sums, peaks, histograms, samples."""

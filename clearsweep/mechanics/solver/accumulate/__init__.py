"""What is summed up along the steps: time histories, sums, peaks, revolutions."""

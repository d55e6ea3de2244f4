"""Statistics of the cases of a run: spreads, effects, trends, kinds of motion, ranges of laws."""

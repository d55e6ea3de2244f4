"""What is made of a run: lives, heat, intervals, the stored trajectory."""

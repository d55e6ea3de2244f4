"""What all rooms hand to each other: a case, a described machine, results, and the names and units of them."""

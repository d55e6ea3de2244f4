"""Laws of the normal force: what loss they add to the elastic force, one block a law."""

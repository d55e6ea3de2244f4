"""Whether results may be believed, and whether a grid allows them."""

"""Laws of contact: each kind has a folder with its contract and its laws."""

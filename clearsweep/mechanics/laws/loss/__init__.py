"""Laws of the normal force: elastic force plus losses, one block per law."""

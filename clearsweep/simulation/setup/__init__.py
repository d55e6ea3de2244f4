"""Set-up of a run: scene, first state, revolutions, arrays."""

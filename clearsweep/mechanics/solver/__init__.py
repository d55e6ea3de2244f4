"""The integrator: two Runge-Kutta methods, event location, and the loop from event to event."""

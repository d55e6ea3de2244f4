"""The integrator: two Runge-Kutta methods, located events, and the loop that goes from one event to the next."""

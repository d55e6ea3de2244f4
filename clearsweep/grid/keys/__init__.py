"""Every key that a grid may contain, with unit, range, default and meaning."""

"""Facts of a finished run that its record and its summary contain."""

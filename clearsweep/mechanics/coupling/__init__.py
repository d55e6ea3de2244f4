"""The mechanism with its joints: its rates, events, wear and trial steps as compiled code."""

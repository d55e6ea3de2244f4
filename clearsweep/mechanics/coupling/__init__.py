"""The mechanism with its joints: rates, events, wear of the whole, and a step as one piece of code."""

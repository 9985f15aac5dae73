"""Maps: a registry of the ways to write one, and the area that is left to move in."""

"""Scenes and runs in words: what is tight, who waits for whom, who is late, who pays with a detour."""

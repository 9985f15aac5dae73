"""What a run leaves on disk: readers beside writers, every file whole or not there."""

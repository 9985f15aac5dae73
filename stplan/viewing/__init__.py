"""Pictures, movies, an interactive page and exports of runs."""

"""Many scenes: planned in processes or on a cluster, resumable, one folder a run."""

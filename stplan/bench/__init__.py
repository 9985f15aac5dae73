"""Measurements of the planner on generated scenes."""

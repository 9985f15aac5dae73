"""Scenes made of other programs' files, and first scenes made of templates."""

"""What `import stplan` offers beside planning itself: scenes made in code, results as tables, pictures."""

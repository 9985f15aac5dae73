"""What scene files are made of: strict mappings, quantities with units, fields that are hashed."""

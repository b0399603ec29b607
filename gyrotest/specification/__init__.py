"""Specs and stations: YAML files → records, every complaint with file, line and key."""

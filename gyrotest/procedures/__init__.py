"""Procedures: one test kind each, what it wants acquired and what it makes of it."""

"""Readers of other people's files: one file a format, each gives blocks of rows."""

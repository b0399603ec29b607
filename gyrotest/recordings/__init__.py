"""Recordings: written as they arrive, kept as Parquet; and the readers of other people's files."""

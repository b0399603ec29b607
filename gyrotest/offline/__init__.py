"""Recordings made elsewhere, analysed without a test run."""

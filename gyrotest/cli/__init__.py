"""`gyrotest …`: everything beside the test run itself."""

from gyrotest.cli.commands import main

__all__ = ["main"]

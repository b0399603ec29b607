"""Speed and memory: run by `make bench`, never as timed tests."""

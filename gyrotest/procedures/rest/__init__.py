"""A record at rest: checked, in °/s, and its bias, for the procedures that take one."""

"""The flow of a run, from the door to the certificate."""

"""gyrotest: production tests of gyroscopes, from a spec to a certificate."""

__version__ = "0.1.0"

"""Bias by reversal: the output at a rate and at the opposite one."""

from gyrotest.procedures.bias_reversal.parameters import BiasReversalParameters
from gyrotest.procedures.bias_reversal.procedure import BiasReversal

__all__ = ["BiasReversal", "BiasReversalParameters"]

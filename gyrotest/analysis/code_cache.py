"""Compiled code on disk, with a checksum: numba runs what it finds there, and would run damaged code too."""

import hashlib
import pickle
from collections.abc import Callable
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.serialize import dumps


class _CheckedCode(CompileResultCacheImpl):
    """What is written and read: the digest of numba's own data, and these."""

    def reduce(self, data: Any) -> Any:
        """Return what is written."""
        code = dumps(super().reduce(data))  # type: ignore[no-untyped-call]
        return hashlib.sha256(code).digest(), code

    def rebuild(self, target_context: Any, reduced_data: Any) -> Any:
        """Return the code of what was read; raises `ValueError` where it is damaged."""
        digest, code = reduced_data
        if hashlib.sha256(code).digest() != digest:
            raise ValueError("the compiled code is damaged")
        return super().rebuild(target_context, pickle.loads(code))  # type: ignore[no-untyped-call]  # noqa: S301


class CheckedCache(FunctionCache):
    """numba's cache of one function, in numba's places."""

    _impl_class = _CheckedCode

    @classmethod
    def keep(cls, dispatcher: Any, function: Callable[..., object]) -> None:
        """Let a dispatcher keep its code here; raises `RuntimeError` where no place can be written."""
        dispatcher._cache = cls(function)

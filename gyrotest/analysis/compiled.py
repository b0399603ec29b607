"""Functions compiled by numba: at their first call, once a machine, outside the interpreter's lock.

A compiled function is plain Python over numbers and arrays. Its annotations say what it takes; numba
is imported when the first one is called. What was compiled is kept where numba keeps it: beside
the source, else in the user's cache folder, or where `NUMBA_CACHE_DIR` says. Where neither can be
written, and where what was kept is damaged, it is compiled anew.
"""

import hashlib
import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import FunctionType
from typing import Annotated, Any, Generic, ParamSpec, TypeVar, cast, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

_P = ParamSpec("_P")
_R = TypeVar("_R")
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Array:
    """A contiguous array: its type of element, its dimensions, whether it is written."""

    element: str
    dimensions: int
    written: bool


Floats = Annotated[NDArray[np.float64], _Array(element="float64", dimensions=1, written=False)]
FloatRows = Annotated[NDArray[np.float64], _Array(element="float64", dimensions=2, written=False)]
Integers = Annotated[NDArray[np.int64], _Array(element="int64", dimensions=1, written=False)]
FloatsOut = Annotated[NDArray[np.float64], _Array(element="float64", dimensions=1, written=True)]
FloatRowsOut = Annotated[NDArray[np.float64], _Array(element="float64", dimensions=2, written=True)]


class Compiled(Generic[_P, _R]):
    """A function that is compiled when it is first called; one that it calls is built into it."""

    def __init__(self, function: Callable[_P, _R], *, reordered_sums: bool) -> None:
        self.plain = function
        # Sums in another order let a loop use vector registers; NaN and infinity stay what they are.
        self._fastmath = {"contract", "reassoc", "nsz"} if reordered_sums else {"contract"}
        self._lock = threading.Lock()
        self._entry: Callable[_P, _R] | None = None
        self._inner: Any = None

    def __call__(self, *args: _P.args, **kwargs: _P.kwargs) -> _R:
        """Call it, compiled first where it is not yet."""
        entry = self._entry
        if entry is None:
            self.prepare()
            entry = cast(Callable[_P, _R], self._entry)
        return entry(*args, **kwargs)

    def prepare(self) -> None:
        """Compile now, so that the first call does not have to."""
        with self._lock:
            if self._entry is None:
                self._entry = self._compiled()

    def _compiled(self) -> Any:
        for cached in (True, True, False):
            try:
                return self._specialised(cached=cached)
            except Exception as error:  # unpickling a damaged file raises whatever it comes upon
                if not cached:
                    raise
                _LOG.debug("cannot use the compiled %s: %r", self.plain.__qualname__, error)
        raise AssertionError

    def _specialised(self, *, cached: bool) -> Any:
        """Compile for the annotated types alone, so that no other array makes a second copy."""
        dispatcher = self._dispatcher(cached=cached)
        if not hasattr(dispatcher, "compile"):
            return dispatcher
        try:
            dispatcher.compile(_signature(self.plain))
        except Exception as error:
            if not dispatcher.signatures:
                if cached:
                    dispatcher._cache.flush()
                raise
            _LOG.debug("cannot keep the compiled %s: %r", self.plain.__qualname__, error)
        dispatcher.disable_compile()
        return dispatcher

    def _dispatcher(self, *, cached: bool) -> Any:
        import numba

        function = cast(FunctionType, self.plain)
        namespace = dict(function.__globals__)
        for name in function.__code__.co_names:
            if isinstance(namespace.get(name), Compiled):
                namespace[name] = namespace[name].inner()
        bound = FunctionType(function.__code__, namespace, function.__name__, function.__defaults__)
        # numba keeps the compiled function by its name and its own file's content, not by what it calls.
        bound.__qualname__ = f"{function.__qualname__}_{self.fingerprint()}"
        dispatcher = numba.njit(nogil=True, fastmath=self._fastmath)(bound)
        if cached and hasattr(dispatcher, "compile"):  # else NUMBA_DISABLE_JIT
            from gyrotest.analysis.code_cache import CheckedCache

            CheckedCache.keep(dispatcher, bound)
        return dispatcher

    def fingerprint(self) -> str:
        """Return what changes with the function, what it calls and the numbers it is written with."""
        function = cast(FunctionType, self.plain)
        digest = hashlib.sha256(function.__code__.co_code)
        digest.update(repr((function.__code__.co_consts, sorted(self._fastmath))).encode())
        for name in function.__code__.co_names:
            value = function.__globals__.get(name)
            if isinstance(value, Compiled):
                digest.update(value.fingerprint().encode())
            elif isinstance(value, int | float | tuple):
                digest.update(repr((name, value)).encode())
        return digest.hexdigest()[:12]

    def inner(self) -> Any:
        """Return it as another compiled function calls it."""
        with self._lock:
            if self._inner is None:
                self._inner = self._dispatcher(cached=False)
            return self._inner


def compiled(function: Callable[_P, _R]) -> Compiled[_P, _R]:
    """Compile a function whose sums keep their order; a product and its sum may be rounded once."""
    return Compiled(function, reordered_sums=False)


def compiled_sums(function: Callable[_P, _R]) -> Compiled[_P, _R]:
    """Compile a function whose sums may be taken in another order, which is several times faster."""
    return Compiled(function, reordered_sums=True)


def _signature(function: Callable[..., object]) -> Any:
    hints = get_type_hints(function, include_extras=True)
    result = _numba_type(hints.pop("return"))
    return result(*map(_numba_type, hints.values()))


def _numba_type(hint: Any) -> Any:
    from numba import types

    plain = {int: types.int64, float: types.float64, bool: types.boolean, type(None): types.none}
    if hint in plain:
        return plain[hint]
    array = get_args(hint)[1]
    return types.Array(getattr(types, array.element), array.dimensions, "C", readonly=not array.written)

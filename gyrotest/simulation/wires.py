"""The servers of a simulated bench: a peer behind a TCP port, a pseudo-terminal or a GPIB adapter."""

from collections.abc import Callable

from gyrotest.errors import StationError
from gyrotest.ports import Clock
from gyrotest.simulation.dialogue import Dialogue
from gyrotest.simulation.figures import fault
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.outlet import Outlet, PtyOutlet, TcpOutlet
from gyrotest.simulation.peer import Addressed, Peer, Talking
from gyrotest.simulation.prologix import PrologixDialogue
from gyrotest.simulation.pump import Pump
from gyrotest.simulation.server import PtyServer, Server, TcpServer, has_pty
from gyrotest.simulation.streaming import Digitizing, Sending

_GPIB_ADDRESS = 22
_WAYS = ("", ":tcp", ":pty", ":prologix", ":prologix-pty")


class Wires:
    """Starts servers and stops them together.

    `port` is the TCP port of each (0: any free one); `hurried`: nobody else moves the clock.
    """

    def __init__(self, clock: Clock, *, port: int = 0, hurried: bool = False) -> None:
        self._clock = clock
        self._port = port
        self._hurried = hurried
        self._servers: list[Server] = []
        self._boards = 0

    def serve(self, name: str, resource: str, peer: Peer) -> str:
        """Start the server for a resource; the VISA address of what it serves."""
        way = resource.removeprefix("simulated")
        check_way(name, resource)
        if way.startswith(":prologix"):
            return self._adapted(name, peer, pty=way.endswith("-pty"))
        if isinstance(peer, Sending):
            return self._stream(name, peer, way)
        if not isinstance(peer, Talking):
            raise StationError(
                [fault(f"instruments.{name}.resource", f"'{resource}': nothing to serve")]
            )
        if way == ":pty":
            return f"ASRL{self._pty(lambda: peer.dialogue(Interface.SERIAL))}::INSTR"
        return f"TCPIP::127.0.0.1::{self._tcp(lambda: peer.dialogue(Interface.SOCKET))}::SOCKET"

    def _stream(self, name: str, peer: Sending, way: str) -> str:
        """A line on which the peer sends by itself."""
        commanded = isinstance(peer, Digitizing)
        if commanded and way == ":pty":
            message = "it has a TCP port and no serial line; write simulated[:tcp]"
            raise StationError([fault(f"instruments.{name}.resource", message)])
        outlet: Outlet = PtyOutlet() if way == ":pty" else TcpOutlet(self._port)
        pump = Pump(peer.transmit, outlet, self._clock, hurried=self._hurried, attentive=commanded)
        self._servers.append(pump)
        return outlet.address

    def _adapted(self, name: str, peer: Peer, *, pty: bool) -> str:
        """The interface and the instrument behind it, separated by a blank."""
        if not isinstance(peer, Addressed):
            message = "this instrument has no GPIB; write simulated[:tcp|:pty]"
            raise StationError([fault(f"instruments.{name}.resource", message)])
        speakers, board = {_GPIB_ADDRESS: peer.speaker}, self._boards
        self._boards += 1

        def dialogue() -> Dialogue:
            return PrologixDialogue(speakers, self._clock)

        interface = (
            f"PRLGX-ASRL{board}::{self._pty(dialogue)}"
            if pty
            else f"PRLGX-TCPIP{board}::127.0.0.1::{self._tcp(dialogue)}"
        )
        return f"{interface}::INTFC GPIB{board}::{_GPIB_ADDRESS}::INSTR"

    def _tcp(self, dialogue: Callable[[], Dialogue]) -> int:
        server = TcpServer(dialogue, self._clock, port=self._port)
        self._servers.append(server)
        return server.port

    def _pty(self, dialogue: Callable[[], Dialogue]) -> str:
        server = PtyServer(dialogue, self._clock)
        self._servers.append(server)
        return server.path

    def close(self) -> None:
        """Stop all servers; idempotent."""
        while self._servers:
            self._servers.pop().close()


def check_way(name: str, resource: str) -> None:
    """Refuse a simulated resource of an unknown kind, or one that this platform lacks."""
    way = resource.removeprefix("simulated")
    key = f"instruments.{name}.resource"
    if way not in _WAYS:
        message = (
            f"'{resource}' is no simulated resource; write simulated[:tcp|:pty|:prologix|:prologix-pty]"
        )
        raise StationError([fault(key, message)])
    if way.endswith("pty") and not has_pty():
        message = "this platform has no pseudo-terminals; write simulated:tcp"
        raise StationError([fault(key, message)])

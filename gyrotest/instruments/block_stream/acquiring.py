"""An acquisition over the block protocol: what was chosen, where it stands, what went wrong in it."""

from collections.abc import Sequence
from dataclasses import dataclass

from gyrotest.instruments.block_stream.assembly import Assembly, Losses
from gyrotest.instruments.block_stream.messages import Packet
from gyrotest.instruments.pacing import Grid
from gyrotest.instruments.streaming.flow import many
from gyrotest.instruments.synchronous.choice import Choice


@dataclass(slots=True, kw_only=True)
class Acquiring:
    """What is acquired since the source was configured. `triggered`: sample 0 is, or was, taken."""

    choice: Choice
    rate_hz: float
    grid: Grid
    assembly: Assembly
    triggered: bool = False
    recovered: int = 0

    def triggered_by(self, now_s: float, packets: Sequence[Packet]) -> None:
        """These are the first samples: the last of them was taken just now."""
        self.triggered = True
        taken = packets[-1].index + len(packets[-1].raw)
        self.grid.start_s = now_s - taken * self.grid.interval_s

    def remarks(self, damaged: int) -> list[str]:
        """What was lost and clipped; `damaged` blocks came with a bad checksum."""
        told = [
            *_lost(self.assembly.overrun, "by overrun"),
            *_lost(self.assembly.on_the_way, "on the way"),
        ]
        told += [f"{many(damaged, 'block')} with bad CRC"] if damaged else []
        if not told and not self.recovered:
            told.append("no sample lost")
        told += self.assembly.clipping.remarks()
        if self.recovered:
            told.append(
                f"connected anew {many(self.recovered, 'time')}; what came after has its place by the"
                " computer's clock"
            )
        return told


def _lost(losses: Losses, how: str) -> list[str]:
    if not losses.places:
        return []
    return [f"{many(losses.samples, 'sample')} lost {how} in {many(losses.places, 'gap')}"]

"""Which slots of a station take a model."""

from gyrotest.records.station import Station


def fitting_slots(station: Station, model: str) -> tuple[str, ...]:
    """The slots that name the model; where none does, those that name none."""
    named = tuple(name for name, slot in station.slots.items() if model in slot.models)
    return named or tuple(name for name, slot in station.slots.items() if not slot.models)

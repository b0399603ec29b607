"""What must hold of how a model is powered."""

from collections.abc import Iterator

from gyrotest.records.spec import Supply
from gyrotest.specification.checked import Complaint


def supply_complaints(supply: Supply) -> Iterator[Complaint]:
    """Give what is wrong with how the model is powered."""
    for name in ("voltage", "current_limit", "over_voltage", "off_time"):
        value = getattr(supply, name)
        if value.value <= 0:
            yield Complaint(("supply", name), f"'{value}' is not more than zero")
    if supply.over_voltage.to("V") <= supply.voltage.to("V"):
        message = (
            f"'{supply.over_voltage}' is not above the voltage of '{supply.voltage}';"
            " the protection would trip at once"
        )
        yield Complaint(("supply", "over_voltage"), message, (("supply", "voltage"),))

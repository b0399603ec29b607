"""Between a document and its complaints: what reading found, and raising all of it in order."""

from collections.abc import Iterable

from gyrotest.errors import DocumentError, Fault
from gyrotest.specification.checked import Complaint
from gyrotest.specification.yaml_document import YamlDocument

MOST_FAULTS = 50


def known_faults(document: YamlDocument) -> tuple[Complaint, ...]:
    """Return what reading the document found wrong, so that nothing below it is complained of twice."""
    return tuple(Complaint(key, fault.message) for key, fault in document.faults if key)


def raise_faults(
    document: YamlDocument, complaints: Iterable[Complaint], error: type[DocumentError]
) -> None:
    """Raise `error` with every complaint, sorted by line, if there is any."""
    read = dict(document.faults)
    faults = [fault for _, fault in document.faults]
    faults += [document.fault(one.key, one.message) for one in complaints if one.key not in read]
    faults = sorted(dict.fromkeys(faults), key=lambda fault: (fault.line or 0, fault.key))
    if len(faults) > MOST_FAULTS:
        more = f"and {len(faults) - MOST_FAULTS} more faults; mend these first"
        faults = [*faults[:MOST_FAULTS], Fault(document.path, None, "", more)]
    if faults:
        raise error(faults)

"""What the analysed records are called among one another."""

from collections.abc import Sequence

from gyrotest.offline.analysis import Analysis


def title(analysis: Analysis) -> str:
    """Return a record's file, and its column where it was chosen among several."""
    source = analysis.source
    return f"{source.path.name}: {source.name}" if source.name else source.path.name


def titles(analyses: Sequence[Analysis]) -> tuple[str, ...]:
    """Return names that tell records apart: no more of file and column than that needs."""
    paths = {one.source.path for one in analyses}
    if len(paths) == 1:
        return tuple(one.source.name or title(one) for one in analyses)
    if len({one.source.name for one in analyses}) == 1:
        names = tuple(one.source.path.name for one in analyses)
        # Files of one name lie in different folders.
        return (
            names if len(set(names)) == len(paths) else tuple(str(one.source.path) for one in analyses)
        )
    return tuple(title(one) for one in analyses)

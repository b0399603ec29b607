"""What a key of a document means: the one source of its schema, its reference page and its hints."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Described:
    """Annotation of a record's field: what it means and how it is written."""

    text: str
    example: str = ""

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Put the description into the field's JSON Schema."""
        described: dict[str, Any] = handler(schema)
        described["description"] = self.text
        if self.example:
            described["examples"] = [self.example]
        return described


@dataclass(frozen=True, slots=True)
class EarlierCase:
    """Annotation of a parameter that names a case before its own, of a procedure (None: of any)."""

    procedure: str | None = None

    def accepts(self, procedure: str) -> bool:
        """Whether a case of this procedure may be named."""
        return self.procedure is None or procedure == self.procedure

"""The base of every table of a file, and the types of its keys."""

from collections.abc import Callable
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, PlainValidator, model_validator
from pydantic_core import PydanticCustomError

from ..._errors import closest
from ..numbers import TableChoice

_LONGEST_KEY = 100


def problem(message: str, **context: object) -> PydanticCustomError:
    """A validation error with a message that pydantic does not reword.

    **Arguments:**

    - `message`: what is wrong and what is allowed.
    - `context`: `key` names the key at fault when the error is raised for its table.
    """
    return PydanticCustomError("file", "{message}", {"message": message, **context})


class Table(BaseModel):
    """A table of the file; only known keys are allowed."""

    model_config: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", frozen=True, protected_namespaces=()
    )
    #: The part of the mechanism that the table describes, if any.
    choice: ClassVar[TableChoice | None] = None

    @model_validator(mode="before")
    @classmethod
    def _keys(cls, data: Any) -> Any:
        # Before pydantic's own checks, whose errors could not name the closest key or the unit.
        if not isinstance(data, dict):
            raise problem("must be a table of keys")
        for key in data:
            if key not in cls.model_fields:
                known = [name for name in cls.model_fields if name not in data]
                hint = closest(key, known or cls.model_fields) if len(key) < _LONGEST_KEY else ""
                raise problem(f"unknown key; {hint}", key=key)
        for name, field in cls.model_fields.items():
            if field.is_required() and name not in data:
                meaning = f"; give the {field.description}" if field.description else ""
                raise problem(f"is missing{meaning}", key=name)
        return data


def checked(function: Callable[..., object], *args: object) -> PlainValidator:
    """A pydantic type whose value is `function(value, *args)`; its ValueError is the message."""

    def read(value):
        try:
            return function(value, *args)
        except ValueError as error:
            raise problem(str(error)) from error

    return PlainValidator(read)


def read_text(value: object) -> str:
    """A string. **Raises:** `ValueError` if it is anything else."""
    if not isinstance(value, str):
        raise ValueError("must be a string")
    return value


def read_name(value: object) -> str:
    """A name of this package's vocabulary. **Raises:** `ValueError` if it cannot be one."""
    if not (isinstance(value, str) and len(value) <= _LONGEST_KEY):
        raise ValueError("must be a name, as a string")
    if not value.isascii() or not value.replace("_", "").replace(".", "").isalnum():
        raise ValueError("must be a name of letters, digits, _ and .")
    return value


def read_boolean(value: object) -> bool:
    """True or false. **Raises:** `ValueError` if it is anything else."""
    if not isinstance(value, bool):
        raise ValueError("must be true or false")
    return value


def read_choice(value: object, allowed: tuple[str, ...]) -> str:
    """One of several words. **Raises:** `ValueError` if it is none of them."""
    if not isinstance(value, str) or value not in allowed:
        choices = ", ".join(f'"{name}"' for name in allowed)
        raise ValueError(f"choose one of {choices}")
    return value


def read_tables(value: object) -> list[dict[str, Any]]:
    """An array of tables. **Raises:** a validation error if it is not one, or is empty."""
    if not isinstance(value, list) or not all(isinstance(row, dict) for row in value):
        raise problem("must be tables, each under a header in double brackets")
    if not value:
        raise problem("is empty; give at least one table")
    return value

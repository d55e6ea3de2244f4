"""Arrays whose numbers have names: declared once, read and written as attributes by traced and by plain code."""

from collections import namedtuple
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Self

import numpy as np

from .memory import View
from .protocols import Composite


class _Field:
    """A number of a Fields, by its index."""

    def __init__(self, index: int):
        self.index = index

    def __get__(self, record: "Fields | None", owner: type | None = None) -> Any:
        return self if record is None else record.of_one_row()[self.index]

    def __set__(self, record: "Fields", value: Any) -> None:
        record.of_one_row()[self.index] = value


class _WithoutDictionary(type):
    """Makes instances of all subclasses reject attributes that are no field."""

    def __new__(cls, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **keywords: Any) -> type:
        return super().__new__(cls, name, bases, {"__slots__": ()} | namespace, **keywords)


class Fields(Composite, metaclass=_WithoutDictionary):
    """Named numbers in an array, all float64 or all int64, or rows of them.

    A subclass declares a number by an annotation, with unit and meaning in a comment; the order of the declarations is
    the order in memory.  The type is float or int, or a class derived from one of them that says of what kind a number
    is.  A subclass of a subclass has its fields, then its own.  The array is a numpy array or, in a traced body, a
    View: `stepper.growth = 1.0` changes it.  If the array has a further leading axis, `rows[j]` is the Fields of row
    `j`, and `rows.column("growth")` are the numbers of all rows.
    """

    DECLARED: ClassVar[dict[str, type]]  # fields
    SIZE: ClassVar[int]  # their number
    DTYPE: ClassVar[type]
    VALUES: ClassVar[Any]  # NamedTuple with these fields
    __slots__ = ("numbers",)
    numbers: Any

    def __init_subclass__(cls, like: type | None = None, **keywords: Any) -> None:
        """Declare the fields; `like` : a NamedTuple whose fields they are, as float64, instead of annotations."""
        super().__init_subclass__(**keywords)
        own_fields = dict.fromkeys(like.__annotations__, float) if like else cls.__annotations__
        declared = getattr(cls, "DECLARED", {}) | own_fields
        cls.DECLARED = declared
        cls.SIZE = len(declared)
        (cls.DTYPE,) = {float if issubclass(kind, float) else int for kind in declared.values()} or {float}
        cls.VALUES = namedtuple(f"{cls.__name__}Values", declared)
        for index, name in enumerate(declared):
            setattr(cls, name, _Field(index))

    def __init__(self, numbers: np.ndarray | View):
        self.numbers = numbers

    def __len__(self) -> int:
        return len(self.numbers)

    def __iter__(self) -> Iterator[Self]:
        return map(type(self), self.numbers)

    def __getitem__(self, row: Any) -> Self:
        return type(self)(self.numbers[row])

    def of_one_row(self) -> Any:
        """Return the array, which has one axis."""
        if len(self.numbers.shape) != 1:
            raise AttributeError(f"{type(self).__name__} has several rows: choose one, or use `column`")
        return self.numbers

    def column(self, name: str) -> np.ndarray:
        """Return the numbers of a field in all rows, as a view."""
        column: np.ndarray = self.numbers[:, self.index_of(name)]
        return column

    def values(self) -> Any:
        """Return the numbers as a NamedTuple of Python numbers, whose fields read faster, or a list of one per row."""
        numbers = self.numbers.tolist()
        return self.VALUES._make(numbers) if self.numbers.ndim == 1 else list(map(self.VALUES._make, numbers))

    def traced_parts(self) -> tuple[Any, ...]:
        """Return the parts unknown while tracing."""
        return (self.numbers,)

    def copy(self) -> Self:
        """Return the Fields with a copy of their array."""
        return type(self)(self.numbers.copy())

    @classmethod
    def zeros(cls, *rows: int, zeros: Callable[..., np.ndarray] = np.zeros) -> Self:
        """Return Fields of zeros, or rows of them; `zeros` allocates the array."""
        return cls(zeros((*rows, cls.SIZE), dtype=cls.DTYPE))

    @classmethod
    def index_of(cls, name: str) -> int:
        """Return the index of a field."""
        return list(cls.DECLARED).index(name)


class _Row:
    """A row of a Rows, by its index."""

    def __init__(self, index: int):
        self.index = index

    def __get__(self, record: "Rows | None", owner: type | None = None) -> Any:
        return self if record is None else record.numbers[self.index]


class Rows(Fields):
    """Named rows of an array, declared as the numbers of Fields are: `rows.area[i]`."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        """Declare the rows."""
        super().__init_subclass__(**keywords)
        for index, name in enumerate(cls.DECLARED):
            setattr(cls, name, _Row(index))

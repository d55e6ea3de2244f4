"""Columns of Arrow tables: their fields, and their values as arrays of numpy and back, without loading pandas."""

import numpy as np
import pyarrow as pa

from ..contracts.layout import Column

LARGEST = 1e100  # size of a number in results, far above that of a grid; beyond, and if it is not finite, it is null


def field_of(column: Column) -> pa.Field:
    """Return the field of a column; its metadata hold `unit` and `description`."""
    types = {"float": pa.float64(), "int": pa.int64(), "text": pa.string()}
    return pa.field(column.name, types[column.kind], metadata={"unit": column.unit, "description": column.description})


def column_of(values: list, kind: pa.DataType) -> pa.Array:
    """Return a column, null where None or beyond LARGEST; pa.array would import pandas, 0.4 s in every worker."""
    if kind == pa.string():
        valid = np.array([value is not None for value in values], bool)
        texts = [(value or "").encode() for value in values]
        content = [np.cumsum([0, *map(len, texts)]).astype("i4"), b"".join(texts)]
    else:
        numbers = np.array(values, float)  # None is NaN
        valid = np.abs(numbers) <= LARGEST  # False for NaN
        exact_values = numbers if kind == pa.float64() else np.array(values, object)  # a count may exceed 2**53
        content = [np.where(valid, exact_values, 0).astype(kind.to_pandas_dtype())]
    return array_of([np.packbits(valid, bitorder="little"), *content], kind, len(values))


def array_of(buffers: list, kind: pa.DataType, count: int) -> pa.Array:
    """Return an Arrow array of `count` values from raw buffers; None for an absent buffer."""
    return pa.Array.from_buffers(kind, count, [None if buffer is None else pa.py_buffer(buffer) for buffer in buffers])


def is_plausible(column: pa.Array) -> bool:
    """Return whether all values of a column can be from `column_of`: its numbers are up to LARGEST, or null."""
    if column.type != pa.float64():
        return True
    valid_count = np.count_nonzero(np.abs(values_of(column)) <= LARGEST)
    return bool(valid_count == len(column) - column.null_count)


def values_of(column: pa.Array) -> np.ndarray:
    """Return a column as an array: numbers as float64, NaN for null, texts as objects; to_numpy would import pandas."""
    if column.type == pa.string():
        return words_of(column)
    span = slice(column.offset, column.offset + len(column))
    values = np.frombuffer(column.buffers()[1], column.type.to_pandas_dtype())[span].astype(float)
    values[_nulls(column)] = np.nan
    return values


def words_of(column: pa.Array) -> np.ndarray:
    """Return a column of texts as objects, None for null; equal texts are one object."""
    if not len(column):
        return np.empty(0, object)
    encoded = column.dictionary_encode()
    codes = np.frombuffer(encoded.indices.buffers()[1], "i4")[: len(column)].copy()
    codes[_nulls(encoded.indices)] = len(encoded.dictionary)
    vocabulary = np.array([*encoded.dictionary.to_pylist(), None], object)
    values: np.ndarray = vocabulary[codes]
    return values


def _nulls(column: pa.Array) -> np.ndarray:
    """Return the indices of the nulls of a column."""
    if not column.null_count:
        return np.empty(0, int)
    bits = np.unpackbits(np.frombuffer(column.buffers()[0], "u1"), bitorder="little")
    return np.flatnonzero(bits[column.offset : column.offset + len(column)] == 0)

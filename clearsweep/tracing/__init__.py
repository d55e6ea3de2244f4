"""Compiles Python bodies: they run once on symbols, which record the operations as LLVM code.

A function is a body if it is marked (`compiled.family`: `kernel`, `inlined`, `family`), or if a body calls it and it is
written in Python.  `objects.machine_code` compiles any function of numbers, tuples and arrays.  Machine code gives what
Python gives, or the body is refused: `NotTraceableError` says file, line, function, reason and statement, then the
calls that led there.

Supported
---------
Values
    Floats, integers, truth values, tuples and NamedTuples of them, None, texts and functions as constants, numpy arrays
    of float64 and int64, and the values of `protocols`.  Lists and dicts, too, but nothing may change them.
Statements
    Assignments to names, to tuples of names, to items of arrays and to `Fields`; `if`, `for`, `while`, `break`,
    `continue`, `return`, `pass`; `assert` of what is known while tracing.
Expressions
    Arithmetic, comparisons and chains of them, `and`, `or`, `not`, `in`, conditional expressions, items and parts,
    comprehensions, calls, lambdas with plain arguments, attributes, properties and methods.
Functions
    min, max, abs, int, float, bool, len, range, zip, enumerate, isinstance; of math: sqrt, exp, expm1, log, log1p,
    log2, sin, cos, atan, atan2, sinh, cosh, tanh, copysign, floor, isfinite.

What is known while tracing (types, lengths, constants of modules) is computed by Python and costs nothing at run time.
Loops over it are unrolled, but for `for _ in range(n)` and `compiled.choosing.rolled_range`.  A constant is read once:
a later assignment to a name of a module, or to an item of an array there, changes no machine code.

Refused
-------
Whatever has an effect while Python runs the body (`print`, `list.append`, items of lists and dicts), may depend on the
version of Python or of a library (`sum` and `round` of numbers, `//` and `%` of floats, other functions of math and of
numpy), or has no single form (a name that is a number on one path and a tuple on another).  Also: `try`, `with`,
`raise`, `match`, `global`, nested `def` and `class`, generators, `:=`, `else` of a loop, starred targets, texts of
values, operators that a class defines.

Different from Python, by design
--------------------------------
* Where Python raises, machine code goes on: x / 0.0 is an infinity or nan, as are functions outside of their range; an
  integer divided by 0 is divided by 1; int(nan) is 0; an index beyond the end reads other memory.
* Integers have 64 bits and wrap around.
* A product is fused with a sum of the same function: a b + c is rounded once.  Powers with known integer exponents up
  to 16 are products; elementary functions are those of `functions`, within 0.9 units in the last place.
* In arrays of the integration loop, an index known only at run time counts from the first item: it is not negative.
* Loops end: one without effect that does not is removed.

Relied on
---------
* The syntax tree (`ast`), `co_firstlineno` and `co_positions` of CPython 3.11 and later, and sources on disk or in
  `linecache`: no zip, no bytecode alone.  `sources` checks that a source is the code that Python runs.
* llvmlite, which numba brings: `llvmlite.ir` with typed pointers, blocks, phi nodes and identified struct types; of
  `llvmlite.binding` the parser, the new pass manager, object code and JITLink.  No internals of either.
* LLVM: neither fuses nor reorders without flags (tests/test_llvm.py).  The bits are those of one version of LLVM; other
  versions pass the tests of the tracer (`make test-tracer`).
"""

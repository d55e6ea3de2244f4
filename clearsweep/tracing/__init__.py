"""Compiles Python bodies: they run once on symbols, which record the operations as LLVM code."""

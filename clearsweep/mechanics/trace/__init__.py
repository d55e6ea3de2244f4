"""How Python bodies become machine code: they run once on symbols, and what is done to these is written down as LLVM."""

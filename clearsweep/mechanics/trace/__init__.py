"""How Python bodies become machine code: they run once on symbols, which write down what is done to them as LLVM."""

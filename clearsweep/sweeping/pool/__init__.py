"""The pool of processes, and what each of its workers does."""

"""How functions are compiled that only compiled code calls: to be linked into what calls them, no further.

The compiler would make machine code of each of them, though nothing ever calls that: a third of the time that it takes
for a scene.  Of what is entered from outside, it makes all that it always does, of the same intermediate code.
"""

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.typed_passes import NativeLowering


class _Linked(JITCodeLibrary):
    """Code that is optimised and stays as it then is."""

    def _finalize_final_module(self):
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    """Translates a function and enters it among those that may be called, with no address of its own."""

    _name = "lowering_to_be_linked"

    def run_pass(self, state):
        state.library = _Linked(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        lowered = state["cr"]
        known_by = object().__sizeof__  # what its callers look it up by: any built-in function that no other has
        state.targetctx.insert_user_function(known_by, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=known_by)
        return True


class LinkedCompiler(CompilerBase):
    """The compiler with that lowering."""

    def define_pipelines(self):
        """Return the passes."""
        passes, state = PassManager("linked"), self.state
        parts = (
            DefaultPassBuilder.define_untyped_pipeline,
            DefaultPassBuilder.define_typed_pipeline,
            DefaultPassBuilder.define_nopython_lowering_pipeline,
        )
        for part in parts:
            for step, text in part(state).passes:
                passes.add_pass(_Lowering if step is NativeLowering else step, text)
        passes.finalize()
        return [passes]

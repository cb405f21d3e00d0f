"""Machine code of compiled functions that only compiled functions call."""

from __future__ import annotations

from types import FunctionType
from typing import Any

from llvmlite import binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

# Beginning of the names of Numba's variables that hold a function's Python environment.
_ENVIRONMENT = "_ZN08NumbaEnv"


class InlinedCompiler(Compiler):
    """Compiler of functions that become part of their callers' machine code."""

    def compile_extra(self, func: FunctionType) -> Any:
        """Compile a function."""
        codegen = self.state.targetctx.codegen()
        self.state.library = InlinedCode(codegen, func.__qualname__)  # type: ignore[no-untyped-call]
        return super().compile_extra(func)  # type: ignore[no-untyped-call]


class InlinedCode(JITCodeLibrary):
    """Code of a function that LLVM optimises and translates only as part of its callers.

    Numba optimises and translates each function together with its callees. A function that is five
    calls deep would be translated six times, and the first five results would never run.
    """

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code."""
        self._ensure_finalized()  # type: ignore[no-untyped-call]
        return 0

    def _optimize_final_module(self) -> None:
        """Leave optimisation to the callers."""

    def _finalize_final_module(self) -> None:
        """Check the code, and translate only the variables that Numba sets afterwards."""
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._verify_declare_only_symbols()  # type: ignore[no-untyped-call]
        names = (variable.name for variable in self._final_module.global_variables)
        environments = "\n".join(
            f'@"{name}" = common global ptr null' for name in names if name.startswith(_ENVIRONMENT)
        )
        self._codegen._add_module(binding.parse_assembly(environments))
        self._codegen._engine.finalize_object()
        self._finalized = True

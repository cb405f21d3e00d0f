"""OpenGL context without a window, for MuJoCo's drawing."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_int, c_uint, c_void_p
from typing import Any

# EGL's numbers: the platform without a window system, and desktop OpenGL.
_SURFACELESS, _OPENGL = 0x31DD, 0x30A2


class OffscreenContext:
    """OpenGL context by EGL, in the profile in which MuJoCo draws.

    Raises:
        OSError: EGL is missing, or cannot draw without a window.
    """

    def __init__(self) -> None:
        self._egl = _library()
        self._display = self._egl.eglGetPlatformDisplay(_SURFACELESS, None, None)
        major, minor = c_int(), c_int()
        if not self._egl.eglInitialize(self._display, byref(major), byref(minor)):
            raise OSError("EGL cannot be initialised without a window")
        self._context = None
        if self._egl.eglBindAPI(_OPENGL):
            self._context = self._egl.eglCreateContext(self._display, None, None, None)
        if not self._context:
            raise OSError("EGL offers no OpenGL without a window")

    def __enter__(self) -> None:
        if not self._egl.eglMakeCurrent(self._display, None, None, self._context):
            raise OSError("the OpenGL context cannot be made current")

    def __exit__(self, *_: object) -> None:
        self._egl.eglMakeCurrent(self._display, None, None, None)

    def close(self) -> None:
        """Free the context."""
        self._egl.eglDestroyContext(self._display, self._context)


def _library() -> Any:
    """Return the library EGL, with the types of the functions that are called."""
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetPlatformDisplay.restype = egl.eglCreateContext.restype = c_void_p
    egl.eglGetPlatformDisplay.argtypes = [c_uint, c_void_p, c_void_p]
    egl.eglInitialize.argtypes = [c_void_p, c_void_p, c_void_p]
    egl.eglBindAPI.argtypes = [c_uint]
    egl.eglCreateContext.argtypes = egl.eglMakeCurrent.argtypes = [c_void_p] * 4
    egl.eglDestroyContext.argtypes = [c_void_p] * 2
    return egl

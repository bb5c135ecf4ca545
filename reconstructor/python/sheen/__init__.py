# SPDX-License-Identifier: Apache-2.0
from sheen import _native
from sheen._native import Camera, ConfigError, Error, FileError, Model, __version__, build, open

__all__ = ["Camera", "ConfigError", "Error", "FileError", "Model", "build", "open"]
__doc__ = _native.__doc__
for _each in (Camera, Model, build, open):
    _each.__module__ = __name__  # as help() and messages name them

// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace pybind11 {
class module_;
}

namespace sheen {

/// `Error` and what derives from it, as Python's exceptions, with our messages: `FileError` is an `OSError`, too,
/// `ConfigError` a `ValueError`.
void add_exceptions(pybind11::module_& module);

}  // namespace sheen

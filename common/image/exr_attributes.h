// SPDX-License-Identifier: Apache-2.0
// The attributes in the headers of an OpenEXR file, checked before the library reads them.
#pragma once

#include <filesystem>

namespace sheen {

/// The library makes room for what an attribute claims before it reads it, and for most types it does not look at the
/// size that the attribute states: none may claim more than the file holds, or another size than its type has.
/// @throws Error that names the attribute
void check_exr_attributes(const std::filesystem::path& path);

}  // namespace sheen

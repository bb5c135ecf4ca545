// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace sheen {

/// A folder of the data that lies beside a checkout and is not part of it; a test skips where it does not exist.
std::filesystem::path shared_data(const std::string& name);

}  // namespace sheen

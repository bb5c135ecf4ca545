// SPDX-License-Identifier: Apache-2.0
#include "tests/support/shared_data.h"

namespace sheen {

std::filesystem::path shared_data(const std::string& name) {
  return std::filesystem::path(SHEEN_SHARED_DATA) / name;
}

}  // namespace sheen

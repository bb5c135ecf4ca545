// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/base/log.h"

namespace sheen {

/// What the parts of the program have to say goes to standard error while this lives.
struct Logging {
  Logging() { start_logging({}); }
  ~Logging() { stop_logging(); }
  Logging(const Logging&) = delete;
  Logging& operator=(const Logging&) = delete;
};

}  // namespace sheen

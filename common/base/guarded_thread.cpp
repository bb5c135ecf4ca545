// SPDX-License-Identifier: Apache-2.0
#include "common/base/guarded_thread.h"

#include <new>

namespace sheen {

std::string words_of(const std::exception_ptr& error) noexcept {
  try {
    std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
  } catch (const std::exception& known) {
    try {
      return known.what();
    } catch (const std::bad_alloc&) {
    }
  } catch (...) {
    return "unknown error";  // short: takes no memory
  }
  return "out of memory";
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#include "common/base/format.h"

#include <cstdarg>
#include <cstdio>

namespace sheen {

std::string format(const char* pattern, ...) {
  va_list values, again;
  va_start(values, pattern);
  va_copy(again, values);
  const int length = std::vsnprintf(nullptr, 0, pattern, values);
  va_end(values);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  std::vsnprintf(text.data(), text.size() + 1, pattern, again);  // the string's own end takes the closing zero
  va_end(again);
  return text;
}

}  // namespace sheen

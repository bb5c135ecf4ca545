// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <exception>
#include <new>
#include <string>

// What the decoders of all pages exchange with their workers: the file that arrives, errors, and tables of numbers. A
// call that fails gives -1, and the text of `error` says why.
namespace sheen::page {

struct Table {
  const void* data = nullptr;
  std::uint32_t bytes = 0;
};
template <typename Numbers>
Table table_of(const Numbers& numbers) {
  return {numbers.data(), static_cast<std::uint32_t>(numbers.size() * sizeof(*numbers.data()))};
}

/// As far as it has arrived.
inline std::string& file() {
  static std::string bytes;
  return bytes;
}
inline char* room_for(std::uint32_t bytes) {
  file().resize(file().size() + bytes);
  return file().data() + file().size() - bytes;
}

inline std::string& error() {
  static std::string text;
  return text;
}

template <typename Call>
int tried(const Call& call) {
  try {
    return static_cast<int>(call());
  } catch (const std::bad_alloc&) {
    error() = "There is not enough memory for this model.";
  } catch (const std::exception& failed) {
    error() = failed.what();
  }
  return -1;
}

}  // namespace sheen::page

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/errors.h"
#include "common/base/files.h"

namespace sheen {

/// Reads the fields of one of Sheen's own JSON files; every error is a FileError that names the field. For .cpp files.
class JsonFields {
 public:
  using Json = nlohmann::json;

  explicit JsonFields(const std::filesystem::path& path) : path_(path.string()) {}

  /// The parsed file, which must say that it has this format and version. `origin` says how to get such a file.
  Json open(const std::string& format, int version, const std::string& origin) const {
    if (!std::filesystem::exists(path_)) throw FileError(path_, "does not exist; " + origin);
    Json file;
    try {
      file = Json::parse(read_file(path_));
    } catch (const Json::parse_error& error) {
      throw FileError(path_, "is not JSON, at byte " + std::to_string(error.byte));
    }
    if (member(file, "format", "") != format) fail("format", "must be \"" + format + "\"");
    if (const auto found = integer(member(file, "version", ""), "version", 0, 1 << 30); found != version)
      fail("version", "is " + std::to_string(found) + "; this program reads " + std::to_string(version));
    return file;
  }

  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw FileError(path_, "field \"" + field + "\" " + what);
  }
  /// `where` is the path of the object with its trailing dot, or empty.
  const Json& member(const Json& object, const std::string& key, const std::string& where) const {
    if (!object.is_object()) fail(where.empty() ? "(top)" : where, "must be an object");
    const auto it = object.find(key);
    if (it == object.end()) fail(where + key, "is missing");
    return *it;
  }
  double number(const Json& value, const std::string& field, double low, double high) const {
    if (!value.is_number()) fail(field, "must be a number");
    const double number = value.get<double>();
    if (!(number >= low && number <= high))
      fail(field, "must be a number from " + Json(low).dump() + " to " + Json(high).dump());
    return number;
  }
  std::int64_t integer(const Json& value, const std::string& field, std::int64_t low, std::int64_t high) const {
    if (!value.is_number_integer() || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high)
      fail(field, "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    return value.get<std::int64_t>();
  }
  std::string text(const Json& value, const std::string& field) const {
    if (!value.is_string()) fail(field, "must be text");
    return value.get<std::string>();
  }
  const Json& array(const Json& value, const std::string& field, std::size_t least, std::size_t most) const {
    if (!value.is_array() || value.size() < least || value.size() > most)
      fail(field, least == most ? "must list " + std::to_string(least) + " values"
                                : "must be a list of " + std::to_string(least) + " entries or more");
    return value;
  }

 private:
  std::string path_;
};

}  // namespace sheen

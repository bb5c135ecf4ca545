// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace sheen {

/// BLAKE2b of 16 bytes, in hexadecimal: names a content, so that the same content is recognised.
std::string content_hash(std::string_view bytes);

/// The same of a file's bytes, which are read piece by piece. Throws FileError.
std::string content_hash_of_file(const std::filesystem::path& file);

}  // namespace sheen

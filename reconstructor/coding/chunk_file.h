// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sheen {

using Notes = std::map<std::string, std::string>;

/// How the files of one kind of model begin.
struct ChunkFormat {
  std::string_view magic;
  std::uint32_t version = 1;
  std::string_view title;       ///< "surface light field"
  std::string_view older = {};  ///< what is said of earlier versions, behind a comma: what to do
};

// A file is the magic, a 32-bit version and chunks, little-endian: name (4 bytes), CRC-32C of the contents (4), size
// (8), contents. The first chunk, META, holds notes as JSON.

void append_chunk(std::string& out, std::string_view name, std::string_view bytes);

inline constexpr int kSmallestPacking = 19, kQuickPacking = 3;  // levels of zstd
/// By zstd.
std::string packed(std::string_view text, int level = kSmallestPacking);
/// Throws std::runtime_error; also where the size that is claimed is not that of any honest file.
std::string unpacked(std::string_view bytes);

/// Magic, version and META.
std::string start_of_file(const ChunkFormat& format, const Notes& notes);
/// The same file with other notes. Throws FileError.
std::string with_notes(const ChunkFormat& format, std::string_view encoded, const Notes& notes,
                       const std::string& file);
/// Throws FileError.
Notes notes_of(const ChunkFormat& format, std::string_view encoded, const std::string& file);

/// Chunks one after the other; at the end of a file that was cut short there is none. Throws FileError that names the
/// chunk.
class Chunks {
 public:
  /// `position`: of the first chunk to read, where not the file's first one.
  Chunks(const ChunkFormat& format, std::string_view bytes, std::string file, std::size_t position = 0);
  std::size_t position() const { return position_; }  ///< of the next chunk

  /// Empty where the file ends before it is whole.
  std::optional<std::string_view> next(std::string_view name);
  std::string_view required(std::string_view name);
  /// Gives its bytes to `decode`. What that finds wrong (JSON's exceptions, std::invalid_argument, std::runtime_error)
  /// becomes a FileError that names the chunk.
  void read(std::string_view name, const std::function<void(std::string_view)>& decode);
  [[noreturn]] void fail(std::string_view name, const std::string& what) const;

 private:
  std::string_view bytes_;
  std::size_t position_;
  std::string file_;
};

}  // namespace sheen

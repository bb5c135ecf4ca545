// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/capture/capture.h"
#include "common/link/wire.h"

namespace sheen {

/// What an index knows about one capture file.
struct IndexedFile {
  std::string name;  ///< in the session's `captures` folder
  std::uint64_t bytes = 0;
  std::uint32_t crc32c = 0;  ///< of the whole file

  bool operator==(const IndexedFile&) const = default;
};

/// What a capture file says of itself.
struct FoundCapture {
  std::string source_session;
  std::uint64_t sequence = 0;
  IndexedFile file;
};

/// "00000012.capture" for 12.
std::string capture_file_name(std::uint64_t number);
/// The number of such a name; nothing for any other name.
std::optional<std::uint64_t> capture_file_number(const std::string& name);

/// Whole and on the disk under its name when it returns. After a failure nothing has that name, after a kill a whole
/// file or none; only a machine that loses its power may leave a torn one. Throws FileError.
IndexedFile write_capture_file(const std::filesystem::path& folder, std::uint64_t number,
                               const EncodedCapture& capture);

// Each throws FileError that names the file and what is wrong with it.
Capture read_capture_file(const std::filesystem::path& folder, const IndexedFile& file);
/// Reads all of it, unpacks nothing.
void check_capture_file(const std::filesystem::path& folder, const IndexedFile& file);
/// Reads the header only.
CaptureLabel read_capture_label(const std::filesystem::path& folder, const std::string& name);
/// For a file that no index vouches for: it must decode from its first byte to its last.
FoundCapture identify_capture_file(const std::filesystem::path& folder, const std::string& name);

/// Makes changes of names in a folder durable. Throws FileError.
void sync_folder(const std::filesystem::path& folder);

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/chunk_file.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/base/crc32c.h"
#include "common/base/errors.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

// No more memory than the size of a file makes likely.
constexpr std::size_t kMostUnpacked = std::size_t{1} << 28, kDensest = 1000;
constexpr std::string_view kNotesChunk = "META";

struct ChunkHead {
  char name[4];
  std::uint32_t checksum;
  std::uint64_t size;
};

std::uint32_t checksum(std::string_view bytes) {
  return crc32c({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace

void append_chunk(std::string& out, std::string_view name, std::string_view bytes) {
  ChunkHead head{.checksum = checksum(bytes), .size = bytes.size()};
  std::memcpy(head.name, name.data(), sizeof head.name);
  out.append(reinterpret_cast<const char*>(&head), sizeof head);
  out.append(bytes);
}

std::string packed(std::string_view text, int level) {
  std::string out(ZSTD_compressBound(text.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), level));
  return out;
}

std::string unpacked(std::string_view bytes) {
  const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > kMostUnpacked ||
      size > kDensest * (bytes.size() + kDensest))
    throw std::runtime_error("cannot be unpacked");
  std::string out(size, '\0');
  if (ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size()) != size)
    throw std::runtime_error("cannot be unpacked");
  return out;
}

std::string start_of_file(const ChunkFormat& format, const Notes& notes) {
  std::string out(format.magic);
  out.append(reinterpret_cast<const char*>(&format.version), sizeof format.version);
  append_chunk(out, kNotesChunk, packed(Json(notes).dump(-1, ' ', false, Json::error_handler_t::replace)));
  return out;
}

std::string with_notes(const ChunkFormat& format, std::string_view encoded, const Notes& notes,
                       const std::string& file) {
  Chunks chunks(format, encoded, file);
  const std::string_view old = chunks.required(kNotesChunk);
  const std::size_t first = static_cast<std::size_t>(old.data() + old.size() - encoded.data());
  std::string out = start_of_file(format, notes);
  out.append(encoded.substr(first));
  return out;
}

Notes notes_of(const ChunkFormat& format, std::string_view encoded, const std::string& file) {
  Chunks chunks(format, encoded, file);
  const std::string_view notes = chunks.required(kNotesChunk);
  try {
    return Json::parse(unpacked(notes)).get<Notes>();
  } catch (const std::exception& error) {
    chunks.fail(kNotesChunk, error.what());
  }
}

Chunks::Chunks(const ChunkFormat& format, std::string_view bytes, std::string file, std::size_t position)
    : bytes_(bytes), position_(position), file_(std::move(file)) {
  if (!bytes.starts_with(format.magic))
    throw FileError(file_, "is not a file of the kind " + std::string(format.title));
  std::uint32_t version = 0;
  if (bytes.size() < format.magic.size() + sizeof version) throw FileError(file_, "is cut short");
  std::memcpy(&version, bytes.data() + format.magic.size(), sizeof version);
  if (version != format.version)
    throw FileError(file_,
                    "is of version " + std::to_string(version) + ", but this program reads version " +
                        std::to_string(format.version) +
                        (version < format.version && !format.older.empty() ? "; " + std::string(format.older) : ""));
  position_ = std::max(position_, format.magic.size() + sizeof version);
}

std::optional<std::string_view> Chunks::next(std::string_view name) {
  const std::string_view rest = bytes_.substr(position_);
  ChunkHead head;
  if (rest.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, rest.data(), sizeof head);
  if (std::string_view(head.name, sizeof head.name) != name) fail(name, "is not where it should be");
  if (head.size > rest.size() - sizeof head) return std::nullopt;
  const std::string_view bytes = rest.substr(sizeof head, head.size);
  position_ += sizeof head + bytes.size();
  if (checksum(bytes) != head.checksum) fail(name, "is damaged (wrong checksum)");
  return bytes;
}

std::string_view Chunks::required(std::string_view name) {
  const auto bytes = next(name);
  if (!bytes) fail(name, "is missing: the file was cut short");
  return *bytes;
}

void Chunks::read(std::string_view name, const std::function<void(std::string_view)>& decode) {
  const std::string_view bytes = required(name);
  try {
    decode(bytes);
  } catch (const FileError&) {
    throw;
  } catch (const nlohmann::json::exception& error) {
    fail(name, std::string("is no such description: ") + error.what());
  } catch (const std::invalid_argument& error) {
    fail(name, error.what());
  } catch (const std::runtime_error& error) {
    fail(name, error.what());
  }
}

void Chunks::fail(std::string_view name, const std::string& what) const {
  throw FileError(file_, "chunk \"" + std::string(name) + "\" " + what);
}

}  // namespace sheen

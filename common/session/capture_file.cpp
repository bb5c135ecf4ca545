// SPDX-License-Identifier: Apache-2.0
#include "common/session/capture_file.h"

#include <array>
#include <cstdio>
#include <span>

#include "common/base/crc32c.h"
#include "common/base/errors.h"
#include "common/base/file_descriptor.h"
#include "common/base/files.h"
#include "common/link/wire_messages.h"

namespace sheen {

namespace fs = std::filesystem;

namespace {

using ByteSpan = std::span<const std::uint8_t>;

// A capture file: envelope, header size (4 bytes), blob size (8 bytes), header, blob; little-endian.
constexpr std::size_t kPrefixBytes = kEnvelopeBytes + 4 + 8;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t(300) << 20;
constexpr const char* kSuffix = ".capture";
constexpr const char* kUnfinished = "incoming.part";
constexpr std::size_t kLeastDigits = 8, kMostDigits = 15;

[[noreturn]] void cannot_write(const fs::path& path) {
  throw FileError(path.string(),
                  std::string("cannot be written: ") + std::strerror(errno) +
                      (errno == ENOSPC ? "; make room and go on, nothing that was acknowledged is lost" : ""));
}

void write_all(const FileDescriptor& fd, ByteSpan bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd.get(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) cannot_write(path);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

std::array<std::uint8_t, kPrefixBytes> make_prefix(const EncodedCapture& m) {
  std::array<std::uint8_t, kPrefixBytes> prefix{};
  std::memcpy(prefix.data(), m.envelope.data(), kEnvelopeBytes);
  for (std::size_t i = 0; i < 4; ++i) prefix[kEnvelopeBytes + i] = static_cast<std::uint8_t>(m.header.size() >> 8 * i);
  for (std::size_t i = 0; i < 8; ++i)
    prefix[kEnvelopeBytes + 4 + i] = static_cast<std::uint8_t>(m.blob.size() >> 8 * i);
  return prefix;
}

ByteSpan bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The parts of a file, of which `bytes` may be only the beginning.
struct Parts {
  ByteSpan envelope, header, rest;
};

Parts split(const fs::path& path, ByteSpan bytes) {
  std::uint64_t header_bytes = 0;
  if (bytes.size() < kPrefixBytes) throw FileError(path.string(), "is too short for a capture");
  for (std::size_t i = 0; i < 4; ++i) header_bytes |= std::uint64_t(bytes[kEnvelopeBytes + i]) << 8 * i;
  if (header_bytes > bytes.size() - kPrefixBytes) throw FileError(path.string(), "states a header longer than itself");
  const ByteSpan body = bytes.subspan(kPrefixBytes);
  return {bytes.first(kEnvelopeBytes), body.first(header_bytes), body.subspan(header_bytes)};
}

Capture decode(const fs::path& path, ByteSpan bytes) {
  const Parts parts = split(path, bytes);
  try {
    return decode_capture(parts.envelope, parts.header, parts.rest);
  } catch (const ProtocolError& error) {
    throw FileError(path.string(), error.what());
  }
}

std::string read_indexed(const fs::path& path, const IndexedFile& file) {
  if (!capture_file_number(file.name)) throw FileError(path.string(), "is not the name of a capture's file");
  std::string text = read_file(path, kMaxFileBytes);
  if (text.size() != file.bytes)
    throw FileError(path.string(),
                    "has " + std::to_string(text.size()) + " bytes, the index says " + std::to_string(file.bytes));
  if (crc32c(bytes_of(text)) != file.crc32c)
    throw FileError(path.string(), "is damaged: its checksum is not the one in the index");
  return text;
}

}  // namespace

std::string capture_file_name(std::uint64_t number) {
  const std::string digits = std::to_string(number);
  return std::string(digits.size() < kLeastDigits ? kLeastDigits - digits.size() : 0, '0') + digits + kSuffix;
}

std::optional<std::uint64_t> capture_file_number(const std::string& name) {
  const std::size_t digits = name.find_first_not_of("0123456789");
  if (digits < kLeastDigits || digits > kMostDigits || name.substr(digits) != kSuffix) return std::nullopt;
  const std::uint64_t number = std::stoull(name);
  if (capture_file_name(number) != name) return std::nullopt;
  return number;
}

IndexedFile write_capture_file(const fs::path& folder, std::uint64_t number, const EncodedCapture& m) {
  const std::string name = capture_file_name(number);
  fs::path path = folder / kUnfinished;
  const auto prefix = make_prefix(m);
  try {
    const FileDescriptor fd(path, O_WRONLY | O_CREAT | O_TRUNC);
    for (const ByteSpan part : {ByteSpan(prefix), ByteSpan(m.header), ByteSpan(m.blob)}) write_all(fd, part, path);
    if (::rename(path.c_str(), (folder / name).c_str()) != 0) cannot_write(folder / name);
    path = folder / name;
    // With its name already, so that one flush of the file system's journal does for the file and the folder.
    if (::fsync(fd.get()) != 0) cannot_write(path);
    sync_folder(folder);
  } catch (const FileError&) {
    ::unlink(path.c_str());
    throw;
  }
  return {name, prefix.size() + m.header.size() + m.blob.size(), crc32c(m.blob, crc32c(m.header, crc32c(prefix)))};
}

Capture read_capture_file(const fs::path& folder, const IndexedFile& file) {
  const fs::path path = folder / file.name;
  return decode(path, bytes_of(read_indexed(path, file)));
}

void check_capture_file(const fs::path& folder, const IndexedFile& file) {
  read_indexed(folder / file.name, file);
}

CaptureLabel read_capture_label(const fs::path& folder, const std::string& name) {
  const fs::path path = folder / name;
  const std::string text = read_file_start(path, kPrefixBytes + kMaxHeaderBytes);
  const Parts parts = split(path, bytes_of(text));
  try {
    return decode_label(parts.envelope, parts.header);
  } catch (const ProtocolError& error) {
    throw FileError(path.string(), error.what());
  }
}

FoundCapture identify_capture_file(const fs::path& folder, const std::string& name) {
  const fs::path path = folder / name;
  const std::string text = read_file(path, kMaxFileBytes);
  const Capture capture = decode(path, bytes_of(text));
  return {capture.source_session, capture.sequence, {name, text.size(), crc32c(bytes_of(text))}};
}

void sync_folder(const fs::path& folder) {
  const FileDescriptor fd(folder, O_RDONLY | O_DIRECTORY);
  if (::fsync(fd.get()) != 0) cannot_write(folder);
}

}  // namespace sheen

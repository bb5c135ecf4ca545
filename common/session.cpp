// SPDX-License-Identifier: Apache-2.0
#include "common/session.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <span>
#include <utility>

#include "common/crc32c.h"
#include "common/errors.h"
#include "common/files.h"
#include "common/session_index.h"
#include "common/wire_messages.h"

namespace sheen {

namespace fs = std::filesystem;

namespace {

const char* const kIndexFile = "session.sqlite";
const char* const kLockFile = "session.lock";
const char* const kCaptures = "captures";

// A capture file: envelope, header size (4 bytes), blob size (8 bytes), header, blob; little-endian.
constexpr std::size_t kPrefixBytes = kEnvelopeBytes + 4 + 8;

class FileDescriptor {
 public:
  FileDescriptor(const fs::path& path, int flags, mode_t mode = 0644)
      : fd_(::open(path.c_str(), flags | O_CLOEXEC, mode)) {
    if (fd_ < 0) throw FileError(path.string(), std::string("cannot be opened: ") + std::strerror(errno));
  }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void cannot_write(const fs::path& path) {
  throw FileError(path.string(),
                  std::string("cannot be written: ") + std::strerror(errno) +
                      (errno == ENOSPC ? "; make room and go on, nothing that was acknowledged is lost" : ""));
}

void sync_folder(const fs::path& folder) {
  const FileDescriptor fd(folder, O_RDONLY | O_DIRECTORY);
  if (::fsync(fd.get()) != 0) cannot_write(folder);
}

void write_all(const FileDescriptor& fd, std::span<const std::uint8_t> bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd.get(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) cannot_write(path);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

FileDescriptor lock_for_writing(const fs::path& folder) {
  FileDescriptor lock(folder / kLockFile, O_RDWR | O_CREAT);
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
    throw FileError(folder.string(), "another program writes to this session; stop it first");
  return lock;
}

/// Nothing but what a creation that was interrupted leaves behind.
bool may_become_a_session(const fs::path& folder) {
  const fs::path index = kIndexFile;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path name = entry.path().filename();
    const bool leftover = name == kLockFile || name == index.string() + ".part" ||
                          name == index.string() + ".part-journal" ||
                          (name == kCaptures && entry.is_directory() && fs::is_empty(entry.path()));
    if (!leftover) return false;
  }
  return true;
}

std::string file_name(std::uint64_t index) {
  const std::string digits = std::to_string(index);
  return std::string(digits.size() < 8 ? 8 - digits.size() : 0, '0') + digits + ".capture";
}

std::array<std::uint8_t, kPrefixBytes> make_prefix(const EncodedCapture& m) {
  std::array<std::uint8_t, kPrefixBytes> prefix{};
  std::memcpy(prefix.data(), m.envelope.data(), kEnvelopeBytes);
  for (std::size_t i = 0; i < 4; ++i) prefix[kEnvelopeBytes + i] = static_cast<std::uint8_t>(m.header.size() >> 8 * i);
  for (std::size_t i = 0; i < 8; ++i)
    prefix[kEnvelopeBytes + 4 + i] = static_cast<std::uint8_t>(m.blob.size() >> 8 * i);
  return prefix;
}

/// On the disk when it returns, or not there at all.
IndexedFile write_capture(const fs::path& folder, const std::string& name, const EncodedCapture& m) {
  const fs::path path = folder / name;
  const auto prefix = make_prefix(m);
  try {
    const FileDescriptor fd(path, O_WRONLY | O_CREAT | O_TRUNC);
    for (const std::span<const std::uint8_t> part :
         {std::span<const std::uint8_t>(prefix), std::span(m.header), std::span(m.blob)})
      write_all(fd, part, path);
    if (::fsync(fd.get()) != 0) cannot_write(path);
    sync_folder(folder);
  } catch (const FileError&) {
    ::unlink(path.c_str());
    throw;
  }
  return {name, prefix.size() + m.header.size() + m.blob.size(), crc32c(m.blob, crc32c(m.header, crc32c(prefix)))};
}

Capture read_capture(const fs::path& folder, const IndexedFile& file) {
  const fs::path path = folder / file.name;
  const std::string text = read_file(path);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  if (bytes.size() != file.bytes)
    throw FileError(path.string(),
                    "has " + std::to_string(bytes.size()) + " bytes, the index says " + std::to_string(file.bytes));
  if (bytes.size() < kPrefixBytes || crc32c(bytes) != file.crc32c)
    throw FileError(path.string(), "is damaged: its checksum is not the one in the index");
  std::uint64_t header_bytes = 0;
  for (std::size_t i = 0; i < 4; ++i) header_bytes |= std::uint64_t(bytes[kEnvelopeBytes + i]) << 8 * i;
  if (header_bytes > bytes.size() - kPrefixBytes) throw FileError(path.string(), "states a header longer than itself");
  const auto body = bytes.subspan(kPrefixBytes);
  try {
    return decode_capture(bytes.first(kEnvelopeBytes), body.first(header_bytes), body.subspan(header_bytes));
  } catch (const ProtocolError& error) {
    throw FileError(path.string(), error.what());
  }
}

}  // namespace

struct Session::Impl {
  Impl(const fs::path& session_folder, SessionIndex::Access access, std::optional<FileDescriptor> writer_lock)
      : folder(session_folder), lock(std::move(writer_lock)), index(folder / kIndexFile, access) {}

  void drop_files_without_index() const;
  void require_writable() const {
    if (!lock) throw FileError(folder.string(), "the session is open for reading only");
  }

  const fs::path folder;
  const std::optional<FileDescriptor> lock;  // held by the one writer
  SessionIndex index;
  mutable std::mutex mutex;
};

void Session::Impl::drop_files_without_index() const {
  const std::set<std::string> known = index.file_names();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / kCaptures))
    if (!known.contains(entry.path().filename().string())) fs::remove(entry.path());
}

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::Session(Session&&) noexcept = default;
Session::~Session() = default;

bool Session::exists(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / kIndexFile, ignored);
}

Session Session::create(const fs::path& folder) {
  try {
    if (exists(folder)) throw FileError(folder.string(), "holds a session already; open it, or choose another folder");
    fs::create_directories(folder);
    if (!may_become_a_session(folder))
      throw FileError(folder.string(), "is not empty; choose another folder for the session");
    std::optional<FileDescriptor> lock = lock_for_writing(folder);
    fs::create_directories(folder / kCaptures);
    SessionIndex::create(folder / kIndexFile);
    sync_folder(folder);
    sync_folder(fs::absolute(folder).parent_path());
    return Session(std::make_unique<Impl>(folder, SessionIndex::Access::kWrite, std::move(lock)));
  } catch (const fs::filesystem_error& error) {
    throw FileError(folder.string(), "cannot become a session: " + error.code().message());
  }
}

Session Session::open(const fs::path& folder) {
  if (!exists(folder)) throw FileError(folder.string(), "holds no session");
  try {
    std::optional<FileDescriptor> lock = lock_for_writing(folder);
    auto impl = std::make_unique<Impl>(folder, SessionIndex::Access::kWrite, std::move(lock));
    impl->drop_files_without_index();
    return Session(std::move(impl));
  } catch (const fs::filesystem_error& error) {
    throw FileError(folder.string(), "cannot be opened: " + error.code().message());
  }
}

Session Session::open_read_only(const fs::path& folder) {
  if (!exists(folder)) throw FileError(folder.string(), "holds no session");
  return Session(std::make_unique<Impl>(folder, SessionIndex::Access::kReadOnly, std::nullopt));
}

Session Session::open_to_withdraw(const fs::path& folder) {
  if (!exists(folder)) throw FileError(folder.string(), "holds no session");
  return Session(std::make_unique<Impl>(folder, SessionIndex::Access::kWrite, std::nullopt));
}

std::uint64_t Session::append(const Capture& capture) {
  impl_->require_writable();
  const std::lock_guard guard(impl_->mutex);
  if (const auto there = impl_->index.find(capture.source_session, capture.sequence)) return *there;
  const std::uint64_t index = impl_->index.size();
  const EncodedCapture encoded = encode_capture(capture, MessageType::kKeep, Codec::kDeltaZstd);
  const IndexedFile file = write_capture(impl_->folder / kCaptures, file_name(index), encoded);
  // Should this fail, the file stays without an index: the next append writes over it, the next opening drops it.
  impl_->index.insert(index, capture.source_session, capture.sequence, file);
  return index;
}

std::uint64_t Session::size() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index.size();
}

Capture Session::read(std::uint64_t index) const {
  std::optional<IndexedFile> file;
  {
    const std::lock_guard guard(impl_->mutex);
    file = impl_->index.file(index);
  }
  if (!file) throw FileError(impl_->folder.string(), "has no capture " + std::to_string(index));
  return read_capture(impl_->folder / kCaptures, *file);
}

std::map<std::string, std::uint64_t> Session::held() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index.held();
}

bool Session::set_withdrawn(std::uint64_t index, bool withdrawn) {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index.set_withdrawn(index, withdrawn);
}

std::set<std::uint64_t> Session::withdrawn() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index.withdrawn();
}

std::vector<Withdrawal> Session::withdrawals_after(std::uint64_t number) const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index.withdrawals_after(number);
}

std::optional<std::uint64_t> Session::last() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index.last();
}

void Session::set_metadata(const std::string& key, const std::string& value) {
  impl_->require_writable();
  const std::lock_guard guard(impl_->mutex);
  impl_->index.set_metadata(key, value);
}

std::optional<std::string> Session::metadata(const std::string& key) const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index.metadata(key);
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#include "common/session/session.h"

#include <sys/file.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

#include "common/base/errors.h"
#include "common/base/file_descriptor.h"
#include "common/base/log.h"
#include "common/link/wire.h"
#include "common/session/capture_file.h"
#include "common/session/session_index.h"
#include "common/session/session_repair.h"

namespace sheen {

namespace fs = std::filesystem;

namespace {

const char* const kIndexFile = "session.sqlite";
const char* const kLockFile = "session.lock";
const char* const kCaptures = "captures";

constexpr int kLockAttempts = 20;  ///< a reader that looks whether there is a writer holds the lock for a moment
constexpr std::chrono::milliseconds kLockPause{10};

std::optional<FileDescriptor> try_to_lock(const fs::path& folder) {
  FileDescriptor lock(folder / kLockFile, O_RDWR | O_CREAT);
  for (int attempt = 0; ::flock(lock.get(), LOCK_EX | LOCK_NB) != 0; ++attempt) {
    if (attempt == kLockAttempts) return std::nullopt;
    std::this_thread::sleep_for(kLockPause);
  }
  return lock;
}

FileDescriptor lock_for_writing(const fs::path& folder) {
  std::optional<FileDescriptor> lock = try_to_lock(folder);
  if (!lock) throw FileError(folder.string(), "another program writes to this session; stop it first");
  return std::move(*lock);
}

bool has_writer(const fs::path& folder) {
  const int fd = ::open((folder / kLockFile).c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool locked = ::flock(fd, LOCK_SH | LOCK_NB) != 0;
  ::close(fd);
  return locked;
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

/// Keeps an index that cannot be used beside the one that takes its place; returns its new name.
fs::path put_by(const fs::path& index) {
  fs::path kept = index.string() + ".damaged";
  for (int n = 2; fs::exists(kept); ++n) kept = index.string() + ".damaged-" + std::to_string(n);
  if (fs::exists(index)) fs::copy_file(index, kept);
  for (const char* part : {"-wal", "-shm"})
    if (fs::exists(index.string() + part)) fs::rename(index.string() + part, kept.string() + part);
  return kept;
}

}  // namespace

struct Session::Impl {
  explicit Impl(fs::path session_folder) : folder(std::move(session_folder)) {}

  SessionRepair look(SessionIndex::Access access);
  void open_for_writing();
  void open_for_reading();
  void tell() const;
  std::optional<std::uint64_t> find(const Capture& capture) const;
  void require_unlocked() const;
  std::optional<std::uint64_t> give_its_row_to_what_is_written();
  void require_same(const Capture& capture, std::uint64_t index) const;
  IndexedFile file_of(std::uint64_t index) const;
  template <typename Read>
  auto read_or_name_the_remedy(std::uint64_t index, const Read& read) const;
  void require_writable() const {
    if (!lock) throw FileError(folder.string(), "the session is open for reading only");
  }

  const fs::path folder, captures = folder / kCaptures, index_file = folder / kIndexFile;
  std::optional<FileDescriptor> lock;  // held by the one writer
  std::unique_ptr<SessionIndex> index;
  bool index_is_usable = true;
  std::vector<std::string> diagnosis;
  std::mutex appending;                     ///< one `append` at a time: guards the next two
  std::uint64_t next_file = 0;              ///< number of the file that comes next
  std::optional<FoundCapture> without_row;  ///< that is on the disk
  mutable std::mutex mutex;                 ///< guards `index`; never held while a file is written
};

/// Opens the index, or takes what it still gives, and says what it should hold.
SessionRepair Session::Impl::look(SessionIndex::Access access) {
  try {
    if (!fs::exists(index_file)) throw DamagedIndex(index_file.string(), "is missing");
    index = std::make_unique<SessionIndex>(index_file, access, &diagnosis);
    return plan_repair(index->contents(), captures);
  } catch (const DamagedIndex& error) {
    if (!has_capture_files(captures)) throw;
    index.reset();
    index_is_usable = false;
    diagnosis.push_back(std::string(error.what()) + "; its contents are read from the captures");
    return plan_repair(SessionIndex::salvage(index_file), captures);
  }
}

void Session::Impl::open_for_writing() {
  const SessionRepair repair = look(SessionIndex::Access::kWrite);
  if (!index_is_usable) {
    const fs::path kept = put_by(index_file);
    SessionIndex::create(index_file, repair.contents);
    if (fs::exists(kept)) diagnosis.push_back("the unusable index is kept: " + kept.string());
    index = std::make_unique<SessionIndex>(index_file, SessionIndex::Access::kWrite);
  } else if (repair.changed) {
    index->replace(repair.contents);
  }
  for (const auto& [name, aside] : repair.set_aside) fs::rename(captures / name, captures / aside);
  fs::create_directories(captures);
  sync_folder(captures);
  sync_folder(folder);
  for (const IndexRow& row : repair.contents.rows)
    next_file = std::max(next_file, *capture_file_number(row.file.name) + 1);
  diagnosis.insert(diagnosis.end(), repair.findings.begin(), repair.findings.end());
}

void Session::Impl::open_for_reading() {
  const SessionRepair repair = look(SessionIndex::Access::kReadOnly);
  diagnosis.insert(diagnosis.end(), repair.findings.begin(), repair.findings.end());
  if (index_is_usable && !repair.changed) return;
  index = SessionIndex::in_memory(repair.contents);
  diagnosis.push_back(folder.string() +
                      ": opened for reading only, so it is not changed; `serve --session` and `undo` repair the index");
}

void Session::Impl::tell() const {
  for (const std::string& line : diagnosis) log_warning("session", line);
}

std::optional<std::uint64_t> Session::Impl::find(const Capture& capture) const {
  const std::lock_guard guard(mutex);
  return index->find(capture.source_session, capture.sequence);
}

/// What cannot be kept is not written.
void Session::Impl::require_unlocked() const {
  const std::lock_guard guard(mutex);
  index->require_unlocked();
}

/// The index of the last file, where it had no row yet: it is on the disk, and the index was locked meanwhile.
std::optional<std::uint64_t> Session::Impl::give_its_row_to_what_is_written() {
  if (!without_row) return std::nullopt;
  const std::lock_guard guard(mutex);
  const std::uint64_t number = index->append(*without_row);
  without_row.reset();
  return number;
}

void Session::Impl::require_same(const Capture& capture, std::uint64_t number) const {
  Capture there;
  try {
    there = read_capture_file(captures, file_of(number));
  } catch (const FileError&) {  // a damaged one is told when it is read, and no reason to refuse this one
    return;
  }
  if (there.image == capture.image && there.mask == capture.mask) return;
  throw TakenName(folder.string(), "holds another image as number " + std::to_string(capture.sequence) + " of \"" +
                                       capture.source_session +
                                       "\": two sources go by this name; give each its own, or a session of its own");
}

IndexedFile Session::Impl::file_of(std::uint64_t number) const {
  const std::lock_guard guard(mutex);
  if (const std::optional<IndexedFile> file = index->file(number)) return *file;
  throw FileError(folder.string(), "has no capture " + std::to_string(number));
}

template <typename Read>
auto Session::Impl::read_or_name_the_remedy(std::uint64_t number, const Read& read) const {
  const IndexedFile file = file_of(number);
  try {
    return read(file);
  } catch (const FileError& error) {
    throw DamagedCapture(folder.string(),
                         "capture " + std::to_string(number) + " cannot be read: " + error.what() +
                             "; put a copy of the file back, or withdraw the capture: undo --capture " +
                             std::to_string(number));
  }
}

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::Session(Session&&) noexcept = default;
Session::~Session() = default;

bool Session::exists(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / kIndexFile, ignored) || has_capture_files(folder / kCaptures);
}

Session Session::create(const fs::path& folder) {
  try {
    if (exists(folder)) throw FileError(folder.string(), "holds a session already; open it, or choose another folder");
    fs::create_directories(folder);
    if (!may_become_a_session(folder))
      throw FileError(folder.string(), "is not empty; choose another folder for the session");
    auto impl = std::make_unique<Impl>(folder);
    impl->lock.emplace(lock_for_writing(folder));
    fs::create_directories(impl->captures);
    SessionIndex::create(impl->index_file);
    impl->open_for_writing();
    sync_folder(fs::absolute(folder).parent_path());
    return Session(std::move(impl));
  } catch (const fs::filesystem_error& error) {
    throw FileError(folder.string(), "cannot be used for a session: " + error.code().message());
  }
}

Session Session::open(const fs::path& folder) {
  if (!exists(folder)) throw FileError(folder.string(), "holds no session");
  try {
    auto impl = std::make_unique<Impl>(folder);
    impl->lock.emplace(lock_for_writing(folder));
    impl->open_for_writing();
    impl->tell();
    return Session(std::move(impl));
  } catch (const fs::filesystem_error& error) {
    throw FileError(folder.string(), "cannot be opened: " + error.code().message());
  }
}

Session Session::open_read_only(const fs::path& folder) {
  if (!exists(folder)) throw FileError(folder.string(), "holds no session");
  auto impl = std::make_unique<Impl>(folder);
  if (has_writer(folder))  // which has put the index in order, and may just be writing a file
    impl->index = std::make_unique<SessionIndex>(impl->index_file, SessionIndex::Access::kReadOnly);
  else
    impl->open_for_reading();
  impl->tell();
  return Session(std::move(impl));
}

Session Session::open_to_withdraw(const fs::path& folder) {
  if (!exists(folder)) throw FileError(folder.string(), "holds no session");
  try {
    auto impl = std::make_unique<Impl>(folder);
    if (const std::optional<FileDescriptor> lock = try_to_lock(folder))
      impl->open_for_writing();
    else
      impl->index = std::make_unique<SessionIndex>(impl->index_file, SessionIndex::Access::kWrite);
    impl->tell();
    return Session(std::move(impl));
  } catch (const fs::filesystem_error& error) {
    throw FileError(folder.string(), "cannot be opened: " + error.code().message());
  }
}

/// Packing and flushing a capture takes as long as the disk does: meanwhile others may look up, and take back.
std::uint64_t Session::append(const Capture& capture) {
  impl_->require_writable();
  const std::lock_guard in_turn(impl_->appending);
  impl_->give_its_row_to_what_is_written();
  if (const auto there = impl_->find(capture)) {
    impl_->require_same(capture, *there);
    return *there;
  }
  impl_->require_unlocked();
  const EncodedCapture encoded = encode_capture(capture, MessageType::kKeep, Codec::kDeltaZstd);
  while (fs::exists(impl_->captures / capture_file_name(impl_->next_file))) ++impl_->next_file;
  impl_->without_row = FoundCapture{capture.source_session, capture.sequence,
                                    write_capture_file(impl_->captures, impl_->next_file++, encoded)};
  return *impl_->give_its_row_to_what_is_written();
}

std::uint64_t Session::size() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index->size();
}

Capture Session::read(std::uint64_t index) const {
  return impl_->read_or_name_the_remedy(
      index, [&](const IndexedFile& file) { return read_capture_file(impl_->captures, file); });
}

void Session::check(std::uint64_t index) const {
  impl_->read_or_name_the_remedy(index, [&](const IndexedFile& file) { check_capture_file(impl_->captures, file); });
}

CaptureLabel Session::label(std::uint64_t index) const {
  return impl_->read_or_name_the_remedy(
      index, [&](const IndexedFile& file) { return read_capture_label(impl_->captures, file.name); });
}

std::map<std::string, std::uint64_t> Session::held() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index->held();
}

bool Session::set_withdrawn(std::uint64_t index, bool withdrawn) {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index->set_withdrawn(index, withdrawn);
}

std::set<std::uint64_t> Session::withdrawn() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index->withdrawn();
}

std::vector<Withdrawal> Session::withdrawals_after(std::uint64_t number) const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index->withdrawals_after(number);
}

std::optional<std::uint64_t> Session::last() const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index->last();
}

void Session::set_metadata(const std::string& key, const std::string& value) {
  impl_->require_writable();
  const std::lock_guard guard(impl_->mutex);
  impl_->index->set_metadata(key, value);
}

std::optional<std::string> Session::metadata(const std::string& key) const {
  const std::lock_guard guard(impl_->mutex);
  return impl_->index->metadata(key);
}

const std::vector<std::string>& Session::diagnosis() const {
  return impl_->diagnosis;
}

}  // namespace sheen

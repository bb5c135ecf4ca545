// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "common/session/capture_file.h"
#include "common/session/session_types.h"

namespace sheen {

struct IndexRow {
  std::uint64_t index = 0;
  std::string source_session;
  std::uint64_t sequence = 0;
  IndexedFile file;
  bool sane = true;  ///< false where a field has a type or a sign that it never has

  bool operator==(const IndexRow&) const = default;
};

/// All that an index holds.
struct IndexContents {
  std::vector<IndexRow> rows;  ///< by index
  std::vector<Withdrawal> withdrawals;
  std::map<std::string, std::string> metadata;
};

/// The SQLite file of a session. Every change is on the disk when the call returns, but for `append`. Everything throws
/// FileError: SessionBusy when another program holds the file locked, DamagedIndex when it cannot be used.
class SessionIndex {
 public:
  enum class Access { kWrite, kReadOnly };
  /// A new one, whole or not at all; a file that is there is replaced.
  static void create(const std::filesystem::path& file, const IndexContents& contents = {});
  /// One that is on no disk.
  static std::unique_ptr<SessionIndex> in_memory(const IndexContents& contents);
  /// What a damaged one still gives.
  static IndexContents salvage(const std::filesystem::path& file) noexcept;
  /// `note` gets a line where not all of it can be read from here.
  SessionIndex(const std::filesystem::path& file, Access access, std::vector<std::string>* notes = nullptr);
  ~SessionIndex();

  /// Checks the whole database first.
  IndexContents contents() const;
  void replace(const IndexContents& contents);

  std::uint64_t size() const;
  std::optional<std::uint64_t> find(const std::string& source_session, std::uint64_t sequence) const;
  void require_unlocked() const;  ///< throws SessionBusy
  /// Adds a row for a file that is on the disk. Returns its index. Not flushed to the disk, for the file tells as much:
  /// the next call that is, or SQLite's next checkpoint, does that.
  std::uint64_t append(const FoundCapture& capture);
  std::optional<IndexedFile> file(std::uint64_t index) const;
  std::map<std::string, std::uint64_t> held() const;
  bool set_withdrawn(std::uint64_t index, bool withdrawn);
  std::set<std::uint64_t> withdrawn() const;
  std::vector<Withdrawal> withdrawals_after(std::uint64_t number) const;
  std::optional<std::uint64_t> last() const;
  void set_metadata(const std::string& key, const std::string& value);
  std::optional<std::string> metadata(const std::string& key) const;

 private:
  struct Impl;
  class Unflushed;
  explicit SessionIndex(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen

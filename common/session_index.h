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

namespace sheen {

struct Withdrawal;

/// What the index knows about one capture file.
struct IndexedFile {
  std::string name;  ///< in the session's `captures` folder
  std::uint64_t bytes = 0;
  std::uint32_t crc32c = 0;
};

/// The SQLite file of a session. Every change is on the disk when the call returns. Everything throws FileError.
class SessionIndex {
 public:
  enum class Access { kWrite, kReadOnly };
  /// A new one, whole or not at all.
  static void create(const std::filesystem::path& file);
  SessionIndex(const std::filesystem::path& file, Access access);
  ~SessionIndex();

  std::uint64_t size() const;
  std::optional<std::uint64_t> find(const std::string& source_session, std::uint64_t sequence) const;
  /// `index` must be `size()`.
  void insert(std::uint64_t index, const std::string& source_session, std::uint64_t sequence, const IndexedFile& file);
  std::optional<IndexedFile> file(std::uint64_t index) const;
  std::set<std::string> file_names() const;
  std::map<std::string, std::uint64_t> held() const;
  bool set_withdrawn(std::uint64_t index, bool withdrawn);
  std::set<std::uint64_t> withdrawn() const;
  std::vector<Withdrawal> withdrawals_after(std::uint64_t number) const;
  std::optional<std::uint64_t> last() const;
  void set_metadata(const std::string& key, const std::string& value);
  std::optional<std::string> metadata(const std::string& key) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen

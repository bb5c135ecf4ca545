// SPDX-License-Identifier: Apache-2.0
#include "common/session/session_index.h"

#include <sqlite3.h>

#include <cstdint>
#include <utility>

#include "common/session/index_database.h"

namespace sheen {
namespace {

constexpr int kApplicationId = 0x5348454E;  // "SHEN"

/// What version 1 has. `idx` counts captures from 0 without a gap.
const char* const kSchema = R"(
  CREATE TABLE captures (
    idx INTEGER PRIMARY KEY,
    source_session TEXT NOT NULL,
    sequence INTEGER NOT NULL,
    file TEXT NOT NULL UNIQUE,
    bytes INTEGER NOT NULL,
    crc32c INTEGER NOT NULL,
    UNIQUE (source_session, sequence)
  );
  CREATE TABLE metadata (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
)";

/// What version 2 adds: a log, never shortened, of which the last entry of a capture counts.
const char* const kWithdrawals = R"(
  CREATE TABLE IF NOT EXISTS withdrawals (
    number INTEGER PRIMARY KEY,
    idx INTEGER NOT NULL REFERENCES captures (idx),
    withdrawn INTEGER NOT NULL
  );
)";

}  // namespace

struct SessionIndex::Impl {
  std::filesystem::path file;
  Database db;

  Statement prepare(const char* sql) const { return Statement(file, db.get(), sql); }
  void make_tables() const;
  void check_version();
  void migrate();
  void insert(const IndexRow& row) const;
  void insert(const IndexContents& contents) const;
  void read_rows(IndexContents& contents) const;
  void read_withdrawals(IndexContents& contents) const;
  void read_metadata(IndexContents& contents) const;

  int version = 0;
};

/// While it lives, a commit is not flushed to the disk. What is committed after it is, and all that came before.
class SessionIndex::Unflushed {
 public:
  explicit Unflushed(const Impl& index) : index_(index) {
    execute(index.file, index.db.get(), "PRAGMA synchronous = NORMAL");
  }
  ~Unflushed() { sqlite3_exec(index_.db.get(), "PRAGMA synchronous = FULL", nullptr, nullptr, nullptr); }
  Unflushed(const Unflushed&) = delete;
  Unflushed& operator=(const Unflushed&) = delete;

 private:
  const Impl& index_;
};

void SessionIndex::Impl::make_tables() const {
  execute(file, db.get(),
          "PRAGMA application_id = " + std::to_string(kApplicationId) +
              "; PRAGMA user_version = " + std::to_string(kSessionVersion) + ";" + kSchema + kWithdrawals);
}

void SessionIndex::Impl::migrate() {
  if (version == kSessionVersion) return;
  Transaction transaction(file, db.get());
  execute(file, db.get(), std::string(kWithdrawals) + "PRAGMA user_version = " + std::to_string(kSessionVersion));
  transaction.commit();
  version = kSessionVersion;
}

void SessionIndex::Impl::check_version() {
  Statement id = prepare("PRAGMA application_id"), version_query = prepare("PRAGMA user_version");
  id.step();
  version_query.step();
  version = static_cast<int>(version_query.integer(0));
  if (id.integer(0) != kApplicationId || version < 1)
    throw DamagedIndex(file.string(), "is not the index of a Sheen session");
  if (version > kSessionVersion)
    throw FileError(file.string(), "the session has version " + std::to_string(version) +
                                       ", this program reads up to version " + std::to_string(kSessionVersion) +
                                       "; open it with the newer release that wrote it");
}

void SessionIndex::Impl::insert(const IndexRow& row) const {
  prepare("INSERT INTO captures VALUES (?, ?, ?, ?, ?, ?)")
      .bind(row.index)
      .bind(row.source_session)
      .bind(row.sequence)
      .bind(row.file.name)
      .bind(row.file.bytes)
      .bind(row.file.crc32c)
      .step();
}

void SessionIndex::Impl::insert(const IndexContents& contents) const {
  for (const IndexRow& row : contents.rows) insert(row);
  for (const Withdrawal& entry : contents.withdrawals)
    prepare("INSERT INTO withdrawals VALUES (?, ?, ?)")
        .bind(entry.number)
        .bind(entry.capture)
        .bind(std::uint64_t{entry.withdrawn})
        .step();
  for (const auto& [key, value] : contents.metadata)
    prepare("INSERT OR REPLACE INTO metadata VALUES (?, ?)").bind(key).bind(value).step();
}

void SessionIndex::Impl::read_rows(IndexContents& contents) const {
  Statement query = prepare("SELECT idx, source_session, sequence, file, bytes, crc32c FROM captures ORDER BY idx");
  while (query.step()) {
    const bool sane = query.is_count(0) && query.is_count(2) && query.is_count(4) && query.is_count(5) &&
                      query.integer(2) > 0 && query.integer(5) <= UINT32_MAX && !query.text(1).empty();
    contents.rows.push_back({query.integer(0),
                             query.text(1),
                             query.integer(2),
                             {query.text(3), query.integer(4), static_cast<std::uint32_t>(query.integer(5))},
                             sane});
  }
}

void SessionIndex::Impl::read_withdrawals(IndexContents& contents) const {
  if (version < 2) return;
  Statement query = prepare("SELECT number, idx, withdrawn FROM withdrawals ORDER BY number");
  while (query.step()) contents.withdrawals.push_back({query.integer(0), query.integer(1), query.integer(2) != 0});
}

void SessionIndex::Impl::read_metadata(IndexContents& contents) const {
  Statement query = prepare("SELECT key, value FROM metadata");
  while (query.step()) contents.metadata[query.text(0)] = query.text(1);
}

SessionIndex::SessionIndex(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

void SessionIndex::create(const std::filesystem::path& file, const IndexContents& contents) {
  const std::filesystem::path unfinished = file.string() + ".part";
  std::error_code error;
  std::filesystem::remove(unfinished, error);
  std::filesystem::remove(unfinished.string() + "-journal", error);
  {
    const Impl made{file, open_database(file, unfinished.string(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE)};
    execute(file, made.db.get(), "PRAGMA synchronous = FULL");
    Transaction transaction(file, made.db.get());
    made.make_tables();
    made.insert(contents);
    transaction.commit();
  }
  std::filesystem::rename(unfinished, file, error);
  if (error) throw FileError(file.string(), "cannot be written: " + error.message());
}

std::unique_ptr<SessionIndex> SessionIndex::in_memory(const IndexContents& contents) {
  auto impl = std::make_unique<Impl>();
  impl->file = ":memory:";
  impl->db = open_database(impl->file, impl->file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  impl->make_tables();
  impl->version = kSessionVersion;
  impl->insert(contents);
  execute(impl->file, impl->db.get(), "PRAGMA query_only = 1");
  return std::unique_ptr<SessionIndex>(new SessionIndex(std::move(impl)));
}

IndexContents SessionIndex::salvage(const std::filesystem::path& file) noexcept {
  IndexContents contents;
  try {
    Impl damaged{file, open_database(file, file.string(), SQLITE_OPEN_READONLY), kSessionVersion};
    for (const auto read : {&Impl::read_rows, &Impl::read_withdrawals, &Impl::read_metadata}) {
      try {
        (damaged.*read)(contents);
      } catch (const FileError&) {  // what came before it stays
      }
    }
  } catch (const std::exception&) {
  }
  return contents;
}

SessionIndex::SessionIndex(const std::filesystem::path& file, Access access, std::vector<std::string>* notes)
    : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  if (access == Access::kWrite) {
    impl_->db = open_database(file, file.string(), SQLITE_OPEN_READWRITE);
    impl_->check_version();
    execute(file, impl_->db.get(), "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;");
    impl_->migrate();
    return;
  }
  impl_->db = open_database(file, file.string(), SQLITE_OPEN_READONLY);
  try {
    impl_->check_version();
  } catch (const FileError&) {
    // On a read-only disk SQLite cannot make the file in which readers of a write-ahead log meet: the log goes unread.
    if (sqlite3_errcode(impl_->db.get()) != SQLITE_CANTOPEN) throw;
    std::error_code error;
    const std::uintmax_t log_bytes = std::filesystem::file_size(file.string() + "-wal", error);
    if (notes && !error && log_bytes > 0)
      notes->push_back(file.string() +
                       "-wal cannot be read on a disk that cannot be written to: what was taken back "
                       "or put back last may be missing; copy the session to another disk to read all of it");
    impl_->db =
        open_database(file, "file:" + escaped(file.string()) + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    impl_->check_version();
  }
}

SessionIndex::~SessionIndex() = default;

IndexContents SessionIndex::contents() const {
  Statement check = impl_->prepare("PRAGMA integrity_check(1)");
  if (!check.step() || check.text(0) != "ok")
    throw DamagedIndex(impl_->file.string(), "the session's index: " + check.text(0));
  IndexContents contents;
  impl_->read_rows(contents);
  impl_->read_withdrawals(contents);
  impl_->read_metadata(contents);
  return contents;
}

void SessionIndex::replace(const IndexContents& contents) {
  Transaction transaction(impl_->file, impl_->db.get());
  execute(impl_->file, impl_->db.get(), "DELETE FROM captures; DELETE FROM withdrawals; DELETE FROM metadata");
  impl_->insert(contents);
  transaction.commit();
}

std::uint64_t SessionIndex::size() const {
  Statement query = impl_->prepare("SELECT COALESCE(MAX(idx) + 1, 0) FROM captures");
  query.step();
  return query.integer(0);
}

std::optional<std::uint64_t> SessionIndex::find(const std::string& source_session, std::uint64_t sequence) const {
  Statement query = impl_->prepare("SELECT idx FROM captures WHERE source_session = ? AND sequence = ?");
  if (!query.bind(source_session).bind(sequence).step()) return std::nullopt;
  return query.integer(0);
}

void SessionIndex::require_unlocked() const {
  const Transaction nothing(impl_->file, impl_->db.get());
}

std::uint64_t SessionIndex::append(const FoundCapture& capture) {
  const Unflushed unflushed(*impl_);
  Transaction transaction(impl_->file, impl_->db.get());
  const std::uint64_t index = size();
  impl_->insert({index, capture.source_session, capture.sequence, capture.file});
  transaction.commit();
  return index;
}

std::optional<IndexedFile> SessionIndex::file(std::uint64_t index) const {
  Statement query = impl_->prepare("SELECT file, bytes, crc32c FROM captures WHERE idx = ?");
  if (!query.bind(index).step()) return std::nullopt;
  return IndexedFile{query.text(0), query.integer(1), static_cast<std::uint32_t>(query.integer(2))};
}

std::map<std::string, std::uint64_t> SessionIndex::held() const {
  // Sequences are distinct, so the n-th smallest is n exactly as long as none is missing before it.
  Statement query = impl_->prepare(R"(
    SELECT source_session, MAX(sequence) FROM (
      SELECT source_session, sequence, ROW_NUMBER() OVER (PARTITION BY source_session ORDER BY sequence) AS n
      FROM captures)
    WHERE sequence = n GROUP BY source_session)");
  std::map<std::string, std::uint64_t> held;
  while (query.step()) held[query.text(0)] = query.integer(1);
  return held;
}

bool SessionIndex::set_withdrawn(std::uint64_t index, bool withdrawn) {
  if (!file(index))
    throw FileError(impl_->file.string(), "has no capture " + std::to_string(index) + " to withdraw; it has " +
                                              (size() == 0 ? "none" : "0.." + std::to_string(size() - 1)));
  // One statement, so that two programs that ask for the same leave one entry.
  impl_
      ->prepare(R"(
        INSERT INTO withdrawals (idx, withdrawn) SELECT ?1, ?2
        WHERE COALESCE((SELECT withdrawn FROM withdrawals WHERE idx = ?1 ORDER BY number DESC LIMIT 1), 0) != ?2)")
      .bind(index)
      .bind(std::uint64_t{withdrawn})
      .step();
  return sqlite3_changes(impl_->db.get()) > 0;
}

std::set<std::uint64_t> SessionIndex::withdrawn() const {
  std::set<std::uint64_t> captures;
  for (const Withdrawal& entry : withdrawals_after(0)) {
    if (entry.withdrawn)
      captures.insert(entry.capture);
    else
      captures.erase(entry.capture);
  }
  return captures;
}

std::vector<Withdrawal> SessionIndex::withdrawals_after(std::uint64_t number) const {
  std::vector<Withdrawal> entries;
  if (impl_->version < 2) return entries;
  Statement query = impl_->prepare("SELECT number, idx, withdrawn FROM withdrawals WHERE number > ? ORDER BY number");
  query.bind(number);
  while (query.step()) entries.push_back({query.integer(0), query.integer(1), query.integer(2) != 0});
  return entries;
}

std::optional<std::uint64_t> SessionIndex::last() const {
  const std::set<std::uint64_t> gone = withdrawn();
  for (std::uint64_t index = size(); index-- > 0;)
    if (!gone.contains(index)) return index;
  return std::nullopt;
}

void SessionIndex::set_metadata(const std::string& key, const std::string& value) {
  impl_->prepare("INSERT OR REPLACE INTO metadata VALUES (?, ?)").bind(key).bind(value).step();
}

std::optional<std::string> SessionIndex::metadata(const std::string& key) const {
  Statement query = impl_->prepare("SELECT value FROM metadata WHERE key = ?");
  if (!query.bind(key).step()) return std::nullopt;
  return query.text(0);
}

}  // namespace sheen

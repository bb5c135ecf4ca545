// SPDX-License-Identifier: Apache-2.0
#include "common/session/index_database.h"

#include <sqlite3.h>

namespace sheen {
namespace {

/// A program that adds a row or a mark holds the lock for milliseconds. Whoever wants to stop must not wait longer.
constexpr int kBusyMs = 500;

std::string what_failed(sqlite3* db) {
  const int code = db ? sqlite3_errcode(db) : SQLITE_NOMEM;
  const bool disk = code == SQLITE_FULL || code == SQLITE_IOERR;
  return std::string("the session's index: ") + (db ? sqlite3_errmsg(db) : "out of memory") +
         (disk ? "; check that the disk has room and is healthy, then go on: nothing that was acknowledged is lost"
               : "");
}

[[noreturn]] void fail(const std::filesystem::path& file, sqlite3* db) {
  const int code = db ? sqlite3_errcode(db) : SQLITE_NOMEM;
  if (code == SQLITE_BUSY || code == SQLITE_LOCKED)
    throw SessionBusy(file.string(), "another program keeps it locked (a database browser, a backup); close that");
  if (code == SQLITE_CORRUPT || code == SQLITE_NOTADB || code == SQLITE_ERROR || code == SQLITE_MISMATCH)
    throw DamagedIndex(file.string(), what_failed(db));
  throw FileError(file.string(), what_failed(db));
}

}  // namespace

void SqliteCloser::operator()(sqlite3* db) const {
  sqlite3_close(db);
}

void SqliteCloser::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Database open_database(const std::filesystem::path& file, const std::string& name, int flags) {
  sqlite3* raw = nullptr;
  const int status = sqlite3_open_v2(name.c_str(), &raw, flags | SQLITE_OPEN_NOMUTEX, nullptr);
  Database db(raw);
  if (status != SQLITE_OK) fail(file, db.get());
  sqlite3_busy_timeout(db.get(), kBusyMs);
  return db;
}

Statement::Statement(const std::filesystem::path& file, sqlite3* db, const char* sql) : file_(file), db_(db) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(db, sql, -1, &raw, nullptr) != SQLITE_OK) fail(file_, db_);
  statement_.reset(raw);
}

Statement& Statement::bind(std::uint64_t value) {
  check(sqlite3_bind_int64(statement_.get(), ++bound_, static_cast<sqlite3_int64>(value)));
  return *this;
}

Statement& Statement::bind(const std::string& value) {
  check(sqlite3_bind_text(statement_.get(), ++bound_, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT));
  return *this;
}

bool Statement::step() {
  const int status = sqlite3_step(statement_.get());
  if (status != SQLITE_ROW && status != SQLITE_DONE) fail(file_, db_);
  return status == SQLITE_ROW;
}

std::uint64_t Statement::integer(int column) const {
  return static_cast<std::uint64_t>(sqlite3_column_int64(statement_.get(), column));
}

bool Statement::is_count(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_INTEGER &&
         sqlite3_column_int64(statement_.get(), column) >= 0;
}

std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return bytes ? std::string(bytes, sqlite3_column_bytes(statement_.get(), column)) : std::string();
}

void Statement::check(int status) {
  if (status != SQLITE_OK) fail(file_, db_);
}

void execute(const std::filesystem::path& file, sqlite3* db, const std::string& sql) {
  if (sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail(file, db);
}

Transaction::Transaction(const std::filesystem::path& file, sqlite3* db) : file_(file), db_(db) {
  execute(file, db, "BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (!sqlite3_get_autocommit(db_)) sqlite3_exec(db_, "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  execute(file_, db_, "COMMIT");
}

std::string escaped(const std::string& path) {
  std::string out;
  for (const char c : path) {
    if (c == '?')
      out += "%3f";
    else if (c == '#')
      out += "%23";
    else if (c == '%')
      out += "%25";
    else
      out += c;
  }
  return out;
}

}  // namespace sheen

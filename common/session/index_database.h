// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "common/session/session_types.h"

struct sqlite3;
struct sqlite3_stmt;

namespace sheen {

/// SQLite as a session's index uses it. `file` is what an error names and outlives everything here. Everything throws
/// SessionBusy when another program holds the file locked, DamagedIndex when the file or its tables are not as they
/// must be (the statements are fixed, so one that does not fit says the same), FileError else, a full disk included.
struct SqliteCloser {
  void operator()(sqlite3* db) const;
  void operator()(sqlite3_stmt* statement) const;
};
using Database = std::unique_ptr<sqlite3, SqliteCloser>;

/// `name` is the file or an address of it, `flags` are those of sqlite3_open_v2.
Database open_database(const std::filesystem::path& file, const std::string& name, int flags);

/// One prepared statement, its parameters bound in the order in which they come.
class Statement {
 public:
  Statement(const std::filesystem::path& file, sqlite3* db, const char* sql);
  Statement& bind(std::uint64_t value);
  Statement& bind(const std::string& value);
  bool step();  ///< true while there is a row
  std::uint64_t integer(int column) const;
  bool is_count(int column) const;
  std::string text(int column) const;

 private:
  void check(int status);

  const std::filesystem::path& file_;
  sqlite3* db_;
  std::unique_ptr<sqlite3_stmt, SqliteCloser> statement_;
  int bound_ = 0;
};

void execute(const std::filesystem::path& file, sqlite3* db, const std::string& sql);

/// Rolled back unless it is committed.
class Transaction {
 public:
  Transaction(const std::filesystem::path& file, sqlite3* db);
  ~Transaction();
  void commit();

 private:
  const std::filesystem::path& file_;
  sqlite3* db_;
};

/// A file name as part of an SQLite address, in which some characters mean something.
std::string escaped(const std::string& path);

}  // namespace sheen

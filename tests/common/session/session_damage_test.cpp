// SPDX-License-Identifier: Apache-2.0
// What becomes of a session that was damaged, copied in part or meddled with: a table of ways, each opened for writing
// and for reading. Nothing that was whole may be lost, nothing wrong be taken for right, and it must be said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sqlite3.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <memory>
#include <set>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/session/session.h"
#include "tests/support/expect_error.h"
#include "tests/support/expect_same_bits.h"
#include "tests/support/sample_capture.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using testing::expect_same_bits;
using ::testing::HasSubstr;
using testing::sample_capture;

constexpr std::uint64_t kCaptures = 8;   ///< of source "s", sequences 1..8
constexpr std::uint64_t kWithdrawn = 5;  ///< sequence

fs::path file(const fs::path& session, int number) {
  return session / "captures" / ("0000000" + std::to_string(number) + ".capture");
}

void execute(const fs::path& session, const std::string& sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((session / "session.sqlite").c_str(), &db), SQLITE_OK);
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
  sqlite3_close(db);
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

void flip(const fs::path& path, std::size_t at) {
  std::string bytes = read_file(path);
  bytes.at(at) = static_cast<char>(bytes[at] ^ 0x10);
  write(path, bytes);
}

void swap_files(const fs::path& a, const fs::path& b) {
  const std::string first = read_file(a);
  write(a, read_file(b));
  write(b, first);
}

/// As a program that was killed leaves it: the rows are in the write-ahead log.
void make_session(const fs::path& folder) {
  const pid_t pid = ::fork();
  if (pid == 0) {
    Session session = Session::create(folder);
    session.set_metadata("mesh_hash", "abc");
    for (std::uint64_t sequence = 1; sequence <= kCaptures; ++sequence) session.append(sample_capture("s", sequence));
    session.set_withdrawn(kWithdrawn - 1, true);
    ::_exit(0);
  }
  int status = 1;
  ::waitpid(pid, &status, 0);
  ASSERT_EQ(status, 0);
  ASSERT_GT(fs::file_size(folder / "session.sqlite-wal"), 0u);
}

std::multiset<std::string> contents_of(const fs::path& folder) {
  std::multiset<std::string> contents;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) contents.insert(read_file(entry.path()));
  return contents;
}

/// The sequences that can be read, each checked to the bit; what is said of the others goes to `told`.
std::set<std::uint64_t> readable(const Session& session, std::string& told) {
  std::set<std::uint64_t> sequences;
  EXPECT_LE(session.size(), kCaptures + 2);
  for (std::uint64_t i = 0; i < session.size(); ++i) {
    try {
      const Capture capture = session.read(i);
      expect_same_bits(capture, sample_capture("s", capture.sequence));
      EXPECT_TRUE(sequences.insert(capture.sequence).second) << "twice: " << capture.sequence;
    } catch (const DamagedCapture& error) {
      EXPECT_THAT(error.what(), HasSubstr("undo --capture " + std::to_string(i)));
      told += std::string(error.what()) + "\n";
    }
  }
  return sequences;
}

std::set<std::uint64_t> withdrawn_sequences(const Session& session) {
  std::set<std::uint64_t> sequences;
  for (const std::uint64_t index : session.withdrawn()) sequences.insert(session.label(index).sequence);
  return sequences;
}

struct Damage {
  const char* name;
  std::function<void(const fs::path& session)> harm;
  std::set<std::uint64_t> unreadable;  ///< sequences whose only file is not whole any more, or is not the one indexed
  std::vector<std::string> told;       ///< words of the diagnosis or of the errors
  bool mark_survives = true;
};

void keep_index_of_first(const fs::path& session, std::uint64_t captures) {
  execute(session, "DELETE FROM captures WHERE idx >= " + std::to_string(captures));
}

const std::vector<Damage> kDamages{
    {"nothing at all", [](const fs::path&) {}, {}, {}},
    {"a file cut short",
     [](const fs::path& s) { fs::resize_file(file(s, 2), 100); },
     {3},
     {"00000002.capture", "100 bytes"}},
    {"a file without its last byte",
     [](const fs::path& s) { fs::resize_file(file(s, 2), fs::file_size(file(s, 2)) - 1); },
     {3},
     {"00000002.capture"}},
    {"an empty file", [](const fs::path& s) { fs::resize_file(file(s, 0), 0); }, {1}, {"00000000.capture", "0 bytes"}},
    {"a bit of the pixels",
     [](const fs::path& s) { flip(file(s, 7), fs::file_size(file(s, 7)) - 5); },
     {8},
     {"00000007.capture", "checksum"}},
    {"a bit of the header", [](const fs::path& s) { flip(file(s, 3), 60); }, {4}, {"00000003.capture", "checksum"}},
    {"a bit of the stated size", [](const fs::path& s) { flip(file(s, 3), 11); }, {4}, {"00000003.capture"}},
    {"a missing file", [](const fs::path& s) { fs::remove(file(s, 1)); }, {2}, {"00000001.capture", "without a file"}},
    {"a folder in place of a file",
     [](const fs::path& s) {
       fs::remove(file(s, 1));
       fs::create_directory(file(s, 1));
     },
     {2},
     {"00000001.capture", "without a file"}},
    {"two files of one size swapped",
     [](const fs::path& s) {
       // Stored without loss, equal images take equal room; here they are made to.
       const std::size_t size = std::max(fs::file_size(file(s, 5)), fs::file_size(file(s, 6)));
       for (const int n : {5, 6})
         write(file(s, n), read_file(file(s, n)) + std::string(size - fs::file_size(file(s, n)), 0));
       execute(s, "UPDATE captures SET bytes = " + std::to_string(size) + " WHERE idx IN (5, 6)");
       swap_files(file(s, 5), file(s, 6));
     },
     {6, 7},
     {"00000005.capture", "00000006.capture", "checksum"}},
    {"two files swapped",
     [](const fs::path& s) { swap_files(file(s, 4), file(s, 6)); },
     {},
     {"read from the file again"}},
    {"a copy of a file under a free number",
     [](const fs::path& s) { fs::copy_file(file(s, 2), file(s, 9)); },
     {},
     {"00000009.capture", "a copy of s 3"}},
    {"a whole file under another number",
     [](const fs::path& s) { fs::rename(file(s, 2), file(s, 9)); },
     {},
     {"added from the files", "00000009.capture"}},
    {"a torn file without a row",
     [](const fs::path& s) { write(file(s, 8), "torn"); },
     {},
     {"00000008.capture.damaged", "too short"}},
    {"an unfinished file", [](const fs::path& s) { write(s / "captures" / "incoming.part", "torn"); }, {}, {}},
    {"files of strangers",
     [](const fs::path& s) {
       write(s / "captures" / "notes.txt", "mine");
       write(s / "captures" / "00000001.capture~", "mine too");
       write(s / "captures" / "999999999999999.capture", "and this");
       fs::create_directories(s / "captures" / "more");
     },
     {},
     {}},
    {"a stale lock file", [](const fs::path& s) { write(s / "session.lock", "4711"); }, {}, {}},
    {"no lock file", [](const fs::path& s) { fs::remove(s / "session.lock"); }, {}, {}},
    {"no write-ahead log",
     [](const fs::path& s) { fs::remove(s / "session.sqlite-wal"); },
     {},
     {"8 captures", "missing from the index"},
     false},
    {"a write-ahead log cut short",
     [](const fs::path& s) { fs::resize_file(s / "session.sqlite-wal", 9000); },
     {},
     {"missing from the index"},
     false},
    {"an older index", [](const fs::path& s) { keep_index_of_first(s, 5); }, {}, {"3 captures", "00000005.capture"}},
    {"an index that lacks some in the middle",
     [](const fs::path& s) { execute(s, "DELETE FROM captures WHERE idx IN (2, 3)"); },
     {},
     {"2 captures", "00000002.capture"}},
    {"no index",
     [](const fs::path& s) {
       for (const char* name : {"session.sqlite", "session.sqlite-wal", "session.sqlite-shm"}) fs::remove(s / name);
     },
     {},
     {"session.sqlite", "missing", "8 captures"},
     false},
    {"an empty index",
     [](const fs::path& s) {
       fs::remove(s / "session.sqlite-wal");
       write(s / "session.sqlite", "");
     },
     {},
     {"not the index of a Sheen session", "8 captures"},
     false},
    {"an index that is no database",
     [](const fs::path& s) {
       fs::remove(s / "session.sqlite-wal");
       write(s / "session.sqlite", std::string(5000, 'x'));
     },
     {},
     {"not a database", "8 captures"},
     false},
    {"an index cut short",
     [](const fs::path& s) {
       execute(s, "PRAGMA wal_checkpoint(TRUNCATE)");
       fs::resize_file(s / "session.sqlite", fs::file_size(s / "session.sqlite") / 2);
     },
     {},
     {"session.sqlite", "read from the captures"},
     false},
    {"an index without the table of captures",
     [](const fs::path& s) { execute(s, "DROP TABLE captures"); },
     {},
     {"8 captures"},
     false},
    {"an index without the table of marks",
     [](const fs::path& s) { execute(s, "DROP TABLE withdrawals"); },
     {},
     {"no such table"},
     false},
    {"a row of index 9e18",
     [](const fs::path& s) { execute(s, "UPDATE captures SET idx = 9000000000000000000 WHERE idx = 7"); },
     {},
     {}},
    {"a row of index 9e18 and no file",
     [](const fs::path& s) {
       execute(s, "INSERT INTO captures VALUES (9000000000000000000, 's', 99, '9000000000000000000.capture', 1, 1)");
     },
     {},
     {"row 9000000000000000000", "dropped"}},
    {"a row of a negative index",
     [](const fs::path& s) { execute(s, "UPDATE captures SET idx = -3 WHERE idx = 2"); },
     {},
     {}},
    {"gaps between the indices",
     [](const fs::path& s) { execute(s, "UPDATE captures SET idx = idx + 1000000 WHERE idx > 3"); },
     {},
     {},
     false},
    {"negative sizes", [](const fs::path& s) { execute(s, "UPDATE captures SET bytes = -bytes"); }, {}, {"8 captures"}},
    {"wrong sizes",
     [](const fs::path& s) { execute(s, "UPDATE captures SET bytes = bytes + 1"); },
     {},
     {"8 captures", "read from the file"}},
    {"a negative sequence",
     [](const fs::path& s) { execute(s, "UPDATE captures SET sequence = -1 WHERE idx = 1"); },
     {},
     {"00000001.capture"}},
    {"text where numbers belong",
     [](const fs::path& s) { execute(s, "UPDATE captures SET bytes = 'many', crc32c = x'00'"); },
     {},
     {"8 captures"}},
    {"a row that names a file elsewhere",
     [](const fs::path& s) { execute(s, "UPDATE captures SET file = '../../secret' WHERE idx = 0"); },
     {},
     {"00000000.capture"}},
    {"wrong checksums of all",
     [](const fs::path& s) { execute(s, "UPDATE captures SET crc32c = 7 WHERE idx = 6"); },
     {7},
     {"00000006.capture", "checksum"}},
    {"marks of captures that are not there",
     [](const fs::path& s) {
       execute(s, "INSERT INTO withdrawals (idx, withdrawn) VALUES (99, 1), (-1, 1), (9000000000000000000, 1)");
     },
     {},
     {"mark", "of capture 99"}},
    {"metadata that is garbage",
     [](const fs::path& s) {
       execute(s, "INSERT OR REPLACE INTO metadata VALUES ('effort', x'00ff00'), (x'01', 3.5)");
     },
     {},
     {}},
};

class DamagedSession : public ::testing::TestWithParam<Damage> {
 protected:
  static void SetUpTestSuite() {
    pristine_ = std::make_unique<TempFolder>();
    make_session(pristine_->path() / "session");
  }
  static void TearDownTestSuite() { pristine_.reset(); }

  void SetUp() override {
    fs::copy(pristine_->path() / "session", session_, fs::copy_options::recursive);
    GetParam().harm(session_);
    for (std::uint64_t sequence = 1; sequence <= kCaptures; ++sequence)
      if (!GetParam().unreadable.contains(sequence)) whole_.insert(sequence);
  }
  void expect_told(const Session& session, const std::string& errors) {
    std::string all = errors;
    for (const std::string& line : session.diagnosis()) all += line + "\n";
    for (const std::string& word : GetParam().told) EXPECT_THAT(all, HasSubstr(word));
    if (GetParam().told.empty()) EXPECT_EQ(errors, "");
  }
  void expect_marks(const Session& session) {
    if (GetParam().mark_survives)
      EXPECT_EQ(withdrawn_sequences(session), std::set<std::uint64_t>{kWithdrawn});
    else
      EXPECT_LE(session.withdrawn().size(), 1u);
  }

  static std::unique_ptr<TempFolder> pristine_;
  const TempFolder temp_;
  const fs::path session_ = temp_.path() / "a session?mode=ro#1%20";
  std::set<std::uint64_t> whole_;
};

std::unique_ptr<TempFolder> DamagedSession::pristine_;

TEST_P(DamagedSession, IsReadAsFarAsItIsWholeAndLeftAsItIs) {
  std::multiset<std::string> before = contents_of(session_ / "captures");
  std::string told;
  const Session session = Session::open_read_only(session_);
  EXPECT_EQ(readable(session, told), whole_);
  expect_told(session, told);
  expect_marks(session);
  EXPECT_EQ(contents_of(session_ / "captures"), before);
}

TEST_P(DamagedSession, GoesOnWithEverythingThatIsWholeAndDeletesNothing) {
  const std::multiset<std::string> before = contents_of(session_ / "captures");
  std::set<std::uint64_t> now = whole_;
  {
    std::string told;
    Session session = Session::open(session_);
    EXPECT_EQ(readable(session, told), whole_);
    expect_told(session, told);
    expect_marks(session);
    session.append(sample_capture("s", kCaptures + 1));
    now.insert(kCaptures + 1);
  }
  const std::multiset<std::string> after = contents_of(session_ / "captures");
  const std::set<std::string> kept(after.begin(), after.end());
  for (const std::string& bytes : before)
    EXPECT_TRUE(bytes == "torn" || kept.contains(bytes)) << "a file of " << bytes.size() << " bytes is gone";
  std::string told;
  const Session again = Session::open(session_);
  EXPECT_EQ(readable(again, told), now);
  expect_marks(again);
  if (GetParam().unreadable.empty()) EXPECT_THAT(again.diagnosis(), ::testing::IsEmpty()) << "it was put in order";
}

TEST(SessionOnAReadOnlyDisk, IsReadThoughItsIndexWasNotClosed) {
  const TempFolder temp;
  const fs::path folder = temp.path() / "what? 100% #1";
  make_session(folder);
  fs::remove(folder / "session.sqlite-shm");  // else it can be read whole
  constexpr int kNotPermitted = 77;
  const pid_t pid = ::fork();
  if (pid == 0) {
    if (::unshare(CLONE_NEWNS) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) ::_exit(kNotPermitted);
    if (::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) ::_exit(kNotPermitted);
    if (::mount(folder.c_str(), folder.c_str(), nullptr, MS_BIND, nullptr) != 0) ::_exit(kNotPermitted);
    if (::mount(nullptr, folder.c_str(), nullptr, MS_BIND | MS_REMOUNT | MS_RDONLY, nullptr) != 0)
      ::_exit(kNotPermitted);
    try {
      const Session session = Session::open_read_only(folder);
      std::string told;
      if (readable(session, told).size() != kCaptures) ::_exit(1);
      for (const std::string& line : session.diagnosis()) told += line + "\n";
      ::_exit(told.find("session.sqlite-wal cannot be read") == std::string::npos ? 2 : 0);
    } catch (const Error& error) {
      std::fprintf(stderr, "%s\n", error.what());
      ::_exit(3);
    }
  }
  int status = 0;
  ::waitpid(pid, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNotPermitted) GTEST_SKIP() << "remounting a folder read-only is not permitted here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

INSTANTIATE_TEST_SUITE_P(Ways, DamagedSession, ::testing::ValuesIn(kDamages), [](const auto& way) {
  std::string name = way.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

}  // namespace
}  // namespace sheen

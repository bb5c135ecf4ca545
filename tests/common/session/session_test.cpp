// SPDX-License-Identifier: Apache-2.0
#include "common/session/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <random>
#include <thread>

#include "common/base/errors.h"
#include "tests/support/expect_error.h"
#include "tests/support/expect_same_bits.h"
#include "tests/support/sample_capture.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using testing::expect_same_bits;
using testing::sample_capture;

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/// Without the one that a kill may have left unfinished.
std::size_t captures_in(const fs::path& folder) {
  return files_in(folder) - fs::exists(folder / "incoming.part");
}

void flip_byte(const fs::path& file, std::streamoff at) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekg(at);
  const char flipped = static_cast<char>(stream.get() ^ 1);
  stream.seekp(at);
  stream.put(flipped);
}

void execute(const fs::path& file, const char* sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, sql, nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
}

/// Exit status of `body` in a process of its own.
int status_of_child(const std::function<int()>& body) {
  const pid_t pid = ::fork();
  if (pid == 0) ::_exit(body());
  int status = 0;
  ::waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

TEST(Session, CapturesComeBackToTheLastBitAfterReopening) {
  const TempFolder temp;
  const fs::path folder = temp.path() / "a" / "session";
  const Capture masked = sample_capture(PixelFormat::kRGB8, 31, 17, 3, true, 1);
  {
    Session session = Session::create(folder);
    EXPECT_EQ(session.size(), 0u);
    EXPECT_EQ(session.append(sample_capture("s", 1)), 0u);
    EXPECT_EQ(session.append(masked), 1u);
    expect_same_bits(session.read(1), masked);
  }
  for (const auto& open : {Session::open, Session::open_read_only}) {
    const Session session = open(folder);
    EXPECT_EQ(session.size(), 2u);
    expect_same_bits(session.read(0), sample_capture("s", 1));
    expect_same_bits(session.read(1), masked);
    EXPECT_EQ(session.read(1).times.received_ns, masked.times.received_ns);
  }
}

TEST(Session, TheSameCaptureIsKeptOnce) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  EXPECT_EQ(session.append(sample_capture("s", 1)), 0u);
  EXPECT_EQ(session.append(sample_capture("s", 2)), 1u);
  EXPECT_EQ(session.append(sample_capture("s", 1)), 0u);
  EXPECT_EQ(session.append(sample_capture("t", 1)), 2u);
  EXPECT_EQ(session.size(), 3u);
}

TEST(Session, HeldEndsBeforeTheFirstGap) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  for (const std::uint64_t sequence : {1, 2, 4}) session.append(sample_capture("gap", sequence));
  session.append(sample_capture("late", 2));
  for (const std::uint64_t sequence : {3, 1, 2}) session.append(sample_capture("shuffled", sequence));
  EXPECT_EQ(session.held(), (std::map<std::string, std::uint64_t>{{"gap", 2}, {"shuffled", 3}}));
}

TEST(Session, MetadataIsKept) {
  const TempFolder temp;
  {
    Session session = Session::create(temp.path());
    session.set_metadata("mesh", "old");
    session.set_metadata("mesh", "Büste.ply");
  }
  Session session = Session::open_read_only(temp.path());
  EXPECT_EQ(session.metadata("mesh"), "Büste.ply");
  EXPECT_EQ(session.metadata("model"), std::nullopt);
  expect_error([&] { session.set_metadata("a", "b"); }, {"reading only"});
  expect_error([&] { session.append(sample_capture("s", 1)); }, {"reading only"});
}

TEST(Session, OnlyOneWriterButReadersBesideIt) {
  const TempFolder temp;
  Session writer = Session::create(temp.path());
  expect_error([&] { Session::open(temp.path()); }, {temp.path().string(), "another program"});
  const Session reader = Session::open_read_only(temp.path());
  writer.append(sample_capture("s", 1));
  EXPECT_EQ(reader.size(), 1u);
  expect_same_bits(reader.read(0), sample_capture("s", 1));
}

TEST(Session, FoldersThatCannotBeSessionsAreRefused) {
  const TempFolder temp;
  expect_error([&] { Session::open(temp.path() / "none"); }, {"none", "no session"});
  expect_error([&] { Session::open_read_only(temp.path()); }, {"no session"});
  EXPECT_FALSE(Session::exists(temp.path()));
  const fs::path file = temp.write("used/notes.txt", "mine");
  expect_error([&] { Session::create(file.parent_path()); }, {"used", "not empty"});
  expect_error([&] { Session::create(file); }, {"notes.txt"});
  temp.write("foreign/session.sqlite", "this is no database, but it is long enough to be looked at as one........");
  expect_error([&] { Session::open(temp.path() / "foreign"); }, {"session.sqlite"});
  execute(temp.write("other/session.sqlite", ""), "CREATE TABLE t (x)");
  expect_error([&] { Session::open(temp.path() / "other"); }, {"not the index of a Sheen session"});
  { Session::create(temp.path() / "session"); }
  expect_error([&] { Session::create(temp.path() / "session"); }, {"already"});
}

TEST(Session, ACreationThatWasInterruptedMayBeRepeated) {
  const TempFolder temp;
  temp.write("session.lock", "");
  temp.write("session.sqlite.part", "half a data");
  fs::create_directory(temp.path() / "captures");
  Session session = Session::create(temp.path());
  EXPECT_EQ(session.append(sample_capture("s", 1)), 0u);
}

TEST(Session, ANewerVersionIsRefusedNamingBoth) {
  const TempFolder temp;
  { Session::create(temp.path()); }
  execute(temp.path() / "session.sqlite", "PRAGMA user_version = 9");
  for (const auto& open : {Session::open, Session::open_read_only})
    expect_error([&] { open(temp.path()); }, {"version 9", "version 2"});
}

TEST(Session, WhatIsWithdrawnStaysMarkedAndCanBePutBack) {
  const TempFolder temp;
  {
    Session session = Session::create(temp.path());
    EXPECT_EQ(session.last(), std::nullopt);
    for (std::uint64_t sequence = 1; sequence <= 4; ++sequence) session.append(sample_capture("s", sequence));
    EXPECT_EQ(session.last(), 3u);
    EXPECT_TRUE(session.set_withdrawn(3, true));
    EXPECT_FALSE(session.set_withdrawn(3, true)) << "twice is once";
    EXPECT_TRUE(session.set_withdrawn(0, true));
    EXPECT_EQ(session.last(), 2u);
    expect_error([&] { session.set_withdrawn(4, true); }, {"no capture 4", "0..3"});
  }
  Session session = Session::open(temp.path());
  EXPECT_EQ(session.withdrawn(), (std::set<std::uint64_t>{0, 3}));
  EXPECT_EQ(session.size(), 4u);
  expect_same_bits(session.read(3), sample_capture("s", 4));
  EXPECT_EQ(session.held()["s"], 4u) << "the tracker need not send it again";
  EXPECT_EQ(session.append(sample_capture("s", 4)), 3u);
  EXPECT_EQ(session.append(sample_capture("s", 5)), 4u);
  EXPECT_TRUE(session.set_withdrawn(0, false));
  EXPECT_FALSE(session.set_withdrawn(1, false));
  EXPECT_EQ(session.withdrawn(), (std::set<std::uint64_t>{3}));
}

TEST(Session, AReaderWithdrawsBesideTheWriterAndOthersSeeIt) {
  const TempFolder temp;
  Session writer = Session::create(temp.path());
  const Session reader = Session::open_read_only(temp.path());
  for (std::uint64_t sequence = 1; sequence <= 3; ++sequence) writer.append(sample_capture("s", sequence));
  EXPECT_TRUE(reader.withdrawals_after(0).empty());
  Session desk = Session::open_to_withdraw(temp.path());
  expect_error([&] { desk.append(sample_capture("s", 4)); }, {"reading only"});
  desk.set_withdrawn(1, true);
  const std::vector<Withdrawal> first = reader.withdrawals_after(0);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(first[0].capture, 1u);
  EXPECT_TRUE(first[0].withdrawn);
  desk.set_withdrawn(1, false);
  desk.set_withdrawn(2, true);
  const std::vector<Withdrawal> news = reader.withdrawals_after(first[0].number);
  ASSERT_EQ(news.size(), 2u);
  EXPECT_EQ(news[0].capture, 1u);
  EXPECT_FALSE(news[0].withdrawn);
  EXPECT_EQ(writer.withdrawn(), (std::set<std::uint64_t>{2}));
  Session looking = Session::open_read_only(temp.path());
  expect_error([&] { looking.set_withdrawn(0, true); }, {"readonly"});
  expect_error([&] { Session::open_to_withdraw(temp.path() / "none"); }, {"no session"});
}

TEST(Session, SessionsOfVersion1OpenAndCanWithdraw) {
  const TempFolder temp;
  { Session::create(temp.path()).append(sample_capture("s", 1)); }
  execute(temp.path() / "session.sqlite", "DROP TABLE withdrawals; PRAGMA user_version = 1");
  EXPECT_TRUE(Session::open_read_only(temp.path()).withdrawn().empty());
  EXPECT_EQ(Session::open_read_only(temp.path()).last(), 0u);
  EXPECT_TRUE(Session::open_to_withdraw(temp.path()).set_withdrawn(0, true));
  EXPECT_EQ(Session::open(temp.path()).withdrawn(), (std::set<std::uint64_t>{0}));
}

TEST(Session, AWithdrawalSurvivesAKillAndManyAtOnceAreAllKept) {
  const TempFolder temp;
  {
    Session session = Session::create(temp.path());
    for (std::uint64_t sequence = 1; sequence <= 24; ++sequence) session.append(sample_capture("s", sequence));
  }
  std::vector<pid_t> children;
  for (std::uint64_t child = 0; child < 4; ++child) {
    children.push_back(::fork());
    if (children.back() != 0) continue;
    Session desk = Session::open_to_withdraw(temp.path());
    for (std::uint64_t i = 0; i < 6; ++i) desk.set_withdrawn(4 * i + child, true);
    ::kill(::getpid(), SIGKILL);
  }
  for (const pid_t pid : children) ::waitpid(pid, nullptr, 0);
  EXPECT_EQ(Session::open(temp.path()).withdrawn().size(), 24u);
}

TEST(Session, AFileWhoseRowFailedIsNeitherLostNorInTheWay) {
  const TempFolder temp;
  {
    Session session = Session::create(temp.path());
    session.append(sample_capture("s", 1));
    session.append(sample_capture("s", 2));
  }
  execute(temp.path() / "session.sqlite", "DELETE FROM captures WHERE idx = 1");
  Session session = Session::open(temp.path());
  EXPECT_EQ(session.append(sample_capture("s", 2)), 1u) << "it is there already";
  EXPECT_EQ(session.append(sample_capture("s", 3)), 2u);
  expect_same_bits(session.read(1), sample_capture("s", 2));
  ASSERT_EQ(session.diagnosis().size(), 1u);
  EXPECT_THAT(session.diagnosis()[0], ::testing::HasSubstr("00000001.capture"));
}

TEST(Session, ALockedIndexIsToldInTimeAndTheSameCallMaySucceedLater) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((temp.path() / "session.sqlite").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  for (int attempt = 0; attempt < 2; ++attempt)
    expect_error<SessionBusy>([&] { session.append(sample_capture("s", 1)); }, {"session.sqlite", "another program"});
  EXPECT_EQ(files_in(temp.path() / "captures"), 0u) << "what cannot be kept is not written";
  ASSERT_EQ(sqlite3_exec(other, "COMMIT", nullptr, nullptr, nullptr), SQLITE_OK);
  EXPECT_EQ(session.append(sample_capture("s", 1)), 0u);
  sqlite3_close(other);
}

TEST(Session, LabelsAreReadWithoutThePixels) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  session.append(sample_capture("s", 7));
  const fs::path file = temp.path() / "captures/00000000.capture";
  fs::resize_file(file, fs::file_size(file) - 1);
  const CaptureLabel label = session.label(0);
  EXPECT_EQ(label.source_session, "s");
  EXPECT_EQ(label.sequence, 7u);
  EXPECT_EQ(label.name, sample_capture("s", 7).name);
  expect_error<DamagedCapture>([&] { session.check(0); }, {"00000000.capture"});
  fs::resize_file(file, 30);
  expect_error<DamagedCapture>([&] { session.label(0); }, {"00000000.capture"});
}

TEST(Session, DamagedAndMissingFilesAreNamed) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  for (std::uint64_t sequence = 1; sequence <= 4; ++sequence) session.append(sample_capture("s", sequence));
  const fs::path captures = temp.path() / "captures";
  flip_byte(captures / "00000000.capture", 40);
  fs::resize_file(captures / "00000001.capture", 10);
  fs::remove(captures / "00000002.capture");
  expect_error([&] { session.read(0); }, {"00000000.capture", "checksum"});
  expect_error([&] { session.read(1); }, {"00000001.capture", "10 bytes"});
  expect_error([&] { session.read(2); }, {"00000002.capture", "no such file"});
  expect_error([&] { session.read(4); }, {"no capture 4"});
  expect_same_bits(session.read(3), sample_capture("s", 4));
}

TEST(Session, AnInvalidCaptureLeavesNothingBehind) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  Capture capture = sample_capture("s", 1);
  capture.camera.fx = -1;
  EXPECT_THROW(session.append(capture), ProtocolError);
  EXPECT_EQ(session.size(), 0u);
  EXPECT_EQ(files_in(temp.path() / "captures"), 0u);
}

Capture numbered(std::uint64_t sequence) {
  Capture capture = sample_capture(PixelFormat::kBayerRG8, 200, 150, 0, false, static_cast<unsigned>(sequence));
  capture.sequence = sequence;
  return capture;
}

/// Fills the disk that `folder` is on, then makes room: 0 when the session has stayed consistent throughout.
int survive_a_full_disk(const fs::path& folder, const std::function<void()>& make_room) {
  Session session = Session::create(folder);
  std::uint64_t kept = 0;
  try {
    for (; kept < 100'000; ++kept) session.append(numbered(kept + 1));
    return 1;  // never full
  } catch (const FileError&) {
  }
  if (kept < 2) return 2;
  if (session.size() != kept) return 3;
  for (std::uint64_t i = 0; i < kept; ++i)
    if (session.read(i).sequence != i + 1) return 4;
  make_room();
  if (session.append(numbered(kept + 1)) != kept) return 5;
  if (session.held().at(numbered(1).source_session) != kept + 1) return 6;
  return 0;
}

TEST(Session, AFileTooLargeForTheLimitLeavesTheSessionConsistent) {
  const TempFolder temp;
  EXPECT_EQ(status_of_child([&] {
              ::signal(SIGXFSZ, SIG_IGN);
              Session session = Session::create(temp.path());
              session.append(sample_capture("s", 1));
              const rlimit small{200'000, RLIM_INFINITY}, none{RLIM_INFINITY, RLIM_INFINITY};
              ::setrlimit(RLIMIT_FSIZE, &small);
              Capture large = sample_capture(PixelFormat::kRGB8, 800, 600, 0, false, 2);
              large.source_session = "s";
              large.sequence = 2;
              try {
                session.append(large);
                return 1;
              } catch (const FileError&) {
              }
              if (session.size() != 1 || files_in(temp.path() / "captures") != 1) return 2;
              if (session.append(sample_capture("s", 3)) != 1) return 3;  // a small one still fits
              ::setrlimit(RLIMIT_FSIZE, &none);
              if (session.append(large) != 2) return 4;
              return session.held().at("s") == 3 ? 0 : 5;
            }),
            0);
}

TEST(Session, AFullDiskLeavesTheSessionConsistent) {
  const TempFolder temp;
  constexpr int kNotPermitted = 77;
  const int status = status_of_child([&] {
    if (::unshare(CLONE_NEWNS) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return kNotPermitted;
    if (::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return kNotPermitted;
    if (::mount("tmpfs", temp.path().c_str(), "tmpfs", 0, "size=2m") != 0) return kNotPermitted;
    const fs::path ballast = temp.write("ballast", std::string(300'000, 'x'));
    return survive_a_full_disk(temp.path() / "session", [&] { fs::remove(ballast); });
  });
  if (status == kNotPermitted) GTEST_SKIP() << "mounting a small file system is not permitted here";
  EXPECT_EQ(status, 0);
}

TEST(Session, WhatAppendHasReturnedSurvivesAKillAtAnyMoment) {
  std::mt19937 random(8);
  const TempFolder temp;
  { Session::create(temp.path()); }
  std::uint64_t acknowledged = 0;
  for (int round = 0; round < 15; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(::pipe(pipe_ends), 0);
    const pid_t pid = ::fork();
    if (pid == 0) {
      Session session = Session::open(temp.path());
      for (std::uint64_t sequence = session.size() + 1;; ++sequence) {
        session.append(sample_capture("s", sequence));
        if (::write(pipe_ends[1], &sequence, sizeof sequence) != sizeof sequence) ::_exit(1);
      }
    }
    ::close(pipe_ends[1]);
    std::uint64_t sequence = 0;
    for (unsigned n = 1 + random() % 5; n > 0; --n) {
      ASSERT_EQ(::read(pipe_ends[0], &sequence, sizeof sequence), static_cast<ssize_t>(sizeof sequence));
      acknowledged = sequence;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
    while (::read(pipe_ends[0], &sequence, sizeof sequence) == sizeof sequence) acknowledged = sequence;
    ::close(pipe_ends[0]);

    const Session session = Session::open(temp.path());
    ASSERT_GE(session.held()["s"], acknowledged);
    ASSERT_EQ(session.size(), session.held()["s"]);
    ASSERT_EQ(captures_in(temp.path() / "captures"), session.size());
    for (std::uint64_t i = 0; i < session.size(); ++i) ASSERT_EQ(session.read(i).sequence, i + 1);
  }
}

}  // namespace
}  // namespace sheen

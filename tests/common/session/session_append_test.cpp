// SPDX-License-Identifier: Apache-2.0
// A capture on its way to a slow disk, and one whose name is taken.
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <limits>
#include <thread>

#include "common/session/session.h"
#include "tests/support/expect_error.h"
#include "tests/support/expect_same_bits.h"
#include "tests/support/patience.h"
#include "tests/support/sample_capture.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using testing::expect_same_bits;
using testing::sample_capture;

constexpr std::chrono::seconds kLong{10 * testing::kPatienceFactor};

TEST(SessionAppend, WhileTheDiskTakesItsTimeOthersLookUpAndTakeBack) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  session.append(sample_capture("s", 1));
  session.append(sample_capture("s", 2));
  const fs::path slow = temp.path() / "captures" / "incoming.part";  // a pipe that nobody reads yet
  ASSERT_EQ(::mkfifo(slow.c_str(), 0600), 0);
  std::future<void> writing = std::async(std::launch::async, [&] { session.append(sample_capture("s", 3)); });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));

  std::future<bool> others = std::async(std::launch::async, [&] {
    const bool here = session.set_withdrawn(0, true);
    const bool elsewhere = Session::open_to_withdraw(temp.path()).set_withdrawn(1, true);
    return here && elsewhere && session.size() == 2 && session.withdrawn().size() == 2;
  });
  const bool in_time = others.wait_for(kLong) == std::future_status::ready;
  EXPECT_TRUE(in_time) << "undo waits for the disk";
  std::ifstream reader(slow, std::ios::binary);
  reader.ignore(std::numeric_limits<std::streamsize>::max());
  EXPECT_THROW(writing.get(), FileError) << "a pipe cannot be flushed";
  EXPECT_TRUE(others.get());
  EXPECT_EQ(session.append(sample_capture("s", 3)), 2u);
  expect_same_bits(session.read(2), sample_capture("s", 3));
}

/// Locks the index as soon as a capture is being written, as a browser of databases does.
TEST(SessionAppend, ACaptureWhoseRowCouldNotBeAddedIsNotWrittenTwice) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  Capture large = sample_capture(PixelFormat::kRGB8, 4000, 3000, 0, false, 2);
  large.sequence = 1;
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((temp.path() / "session.sqlite").c_str(), &other), SQLITE_OK);
  std::thread locking([&] {
    const auto end = std::chrono::steady_clock::now() + kLong;
    while (!fs::exists(temp.path() / "captures" / "incoming.part") && std::chrono::steady_clock::now() < end) {
    }
    sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr);
  });
  try {
    session.append(large);  // a disk that was quicker than the lock is fine
  } catch (const SessionBusy&) {
  }
  locking.join();
  sqlite3_exec(other, "COMMIT", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_EQ(session.append(large), 0u);
  EXPECT_EQ(session.append(sample_capture(large.source_session, 2)), 1u);
  EXPECT_EQ(session.size(), 2u);
  EXPECT_EQ(std::distance(fs::directory_iterator(temp.path() / "captures"), fs::directory_iterator()), 2);
}

TEST(SessionAppend, AnotherImageByATakenNameIsRefused) {
  const TempFolder temp;
  Session session = Session::create(temp.path());
  const Capture first = sample_capture(PixelFormat::kRGB8, 31, 17, 0, true, 1);
  session.append(first);
  Capture again = first;
  again.times = {1, 2, 3, 4};
  EXPECT_EQ(session.append(again), 0u) << "sent once more";
  Capture other_image = first, other_mask = first;
  other_image.image.bytes[7] ^= 1;
  other_mask.mask.data()[7] ^= 255;
  for (const Capture& other : {other_image, other_mask})
    expect_error<TakenName>([&] { session.append(other); },
                            {temp.path().string(), "another image", "41", first.source_session, "two sources"});
  EXPECT_EQ(session.size(), 1u);
  expect_same_bits(session.read(0), first);
}

}  // namespace
}  // namespace sheen
